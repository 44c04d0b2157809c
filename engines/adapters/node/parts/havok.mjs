// Havok's calls, whose result codes are checked.
// Each call of the module returns a code, [code, value] or [code, value, …]. Each call of `checked`
// returns nothing, the value, or an array of the values; it throws if the code is not RESULT_OK.
export const checked = (module) => new Proxy(module, { get: (_, name) => {
  const call = module[name];
  if (!String(name).startsWith('HP_')) return call;
  return (...given) => {
    const [code, ...values] = [call(...given)].flat(1);
    if (code !== module.Result.RESULT_OK) throw new Error(`Havok says ${code.value ?? code}`);
    return values.length > 1 ? values : values[0];
  };
} });
