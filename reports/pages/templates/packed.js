// What a page carries deflated, unpacked: the items of its element #packed, by number, and the
// source of Plotly. At once, without the browser's streams: printing waits for nothing.
const spincheck = (() => {
  "use strict";

  function bytes(base64) {
    const raw = atob(base64);
    const out = new Uint8Array(raw.length);
    for (let k = 0; k < raw.length; k++) out[k] = raw.charCodeAt(k);
    return out;
  }

  // RFC 1951: lengths and distances by their codes, and the order of the lengths of code lengths.
  const LENGTHS = [3, 4, 5, 6, 7, 8, 9, 10, 11, 13, 15, 17, 19, 23, 27, 31, 35, 43, 51, 59, 67, 83, 99, 115, 131, 163, 195, 227, 258];
  const DISTANCES = [1, 2, 3, 4, 5, 7, 9, 13, 17, 25, 33, 49, 65, 97, 129, 193, 257, 385, 513, 769, 1025, 1537, 2049, 3073, 4097, 6145, 8193, 12289, 16385, 24577];
  const ORDER = [16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15];
  const lengthBits = (code) => (code < 8 || code === 28 ? 0 : (code >> 2) - 1);
  const distanceBits = (code) => (code < 4 ? 0 : (code >> 1) - 1);

  // A canonical Huffman code: how many symbols have each length, and the symbols in order.
  function huffman(lengths) {
    const counts = new Uint16Array(16), starts = new Uint16Array(17), symbols = new Uint16Array(lengths.length);
    for (const length of lengths) counts[length]++;
    counts[0] = 0;
    for (let k = 1; k < 16; k++) starts[k + 1] = starts[k] + counts[k];
    lengths.forEach((length, symbol) => { if (length) symbols[starts[length]++] = symbol; });
    return { counts, symbols };
  }
  const fixed = () => [
    huffman(Array.from({ length: 288 }, (_, k) => (k < 144 ? 8 : k < 256 ? 9 : k < 280 ? 7 : 8))),
    huffman(Array(30).fill(5))];

  // zlib's format (RFC 1950), without its check sum.
  function inflated(input) {
    let out = new Uint8Array(8 * input.length), size = 0, at = 2, hold = 0, held = 0;

    function bits(count) {
      while (held < count) {
        hold |= input[at++] << held;
        held += 8;
      }
      const value = hold & ((1 << count) - 1);
      hold >>>= count;
      held -= count;
      return value;
    }
    function symbol({ counts, symbols }) {
      let code = 0, first = 0, index = 0;
      for (let length = 1; length < 16; length++) {
        code |= bits(1);
        const count = counts[length];
        if (code - first < count) return symbols[index + code - first];
        index += count;
        first = (first + count) << 1;
        code <<= 1;
      }
      throw new Error("this page's data is damaged: write the report again");
    }
    function codes() {
      const literals = bits(5) + 257, distances = bits(5) + 1, given = Array(19).fill(0), lengths = [];
      for (let k = bits(4) + 4, j = 0; j < k; j++) given[ORDER[j]] = bits(3);
      const code = huffman(given);
      while (lengths.length < literals + distances) {
        const next = symbol(code);
        if (next < 16) lengths.push(next);
        else if (next === 16) lengths.push(...Array(3 + bits(2)).fill(lengths.at(-1)));
        else lengths.push(...Array(next === 17 ? 3 + bits(3) : 11 + bits(7)).fill(0));
      }
      return [huffman(lengths.slice(0, literals)), huffman(lengths.slice(literals))];
    }
    function room(more) {
      if (size + more <= out.length) return;
      const wider = new Uint8Array(2 * (size + more));
      wider.set(out.subarray(0, size));
      out = wider;
    }
    function stored() {
      hold = held = 0;
      const length = input[at] | (input[at + 1] << 8);
      room(length);
      out.set(input.subarray(at + 4, at + 4 + length), size);
      size += length;
      at += 4 + length;
    }
    function compressed([literals, distances]) {
      for (let next; (next = symbol(literals)) !== 256; ) {
        room(258);
        if (next < 256) {
          out[size++] = next;
          continue;
        }
        const length = LENGTHS[next - 257] + bits(lengthBits(next - 257)), far = symbol(distances);
        const distance = DISTANCES[far] + bits(distanceBits(far));
        for (const end = size + length; size < end; size++) out[size] = out[size - distance];
      }
    }

    for (let last = false; !last; ) {
      last = bits(1) === 1;
      const kind = bits(2);
      if (kind === 0) stored();
      else compressed(kind === 1 ? fixed() : codes());
    }
    return out.subarray(0, size);
  }

  const unpacked = (base64) => inflated(bytes(base64));
  const text = (encoded) => new TextDecoder().decode(encoded);

  const element = document.getElementById("packed");
  const data = element ? unpacked(element.textContent.trim()) : new Uint8Array([91, 93, 0]);
  // JSON, a NUL, and the arrays.
  const end = data.indexOf(0), items = JSON.parse(text(data.subarray(0, end)));

  // An array as `differences.py` packs it: bytes in planes, zigzag-coded differences.
  function restored({ at, length, width, step, order, gaps }) {
    const values = Array(length).fill(0);
    for (let plane = width - 1; plane >= 0; plane--)
      for (let k = 0; k < length; k++)
        values[k] = 256 * values[k] + data[end + 1 + at + plane * length + k];
    for (let k = 0; k < length; k++)
      values[k] = values[k] % 2 ? -(values[k] + 1) / 2 : values[k] / 2;
    for (let j = 0; j < order; j++)
      for (let k = 1; k < length; k++) values[k] += values[k - 1];
    for (let k = 0; k < length; k++) values[k] *= step;
    for (const k of gaps) values[k] = NaN;
    return values;
  }

  const source = (base64) => text(unpacked(base64));
  return { items, restored, source };
})();
