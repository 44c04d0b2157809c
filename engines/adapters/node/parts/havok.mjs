// Havok's calls with their result codes looked at.
// Each call of the module gives a code, [code, value] or [code, value, …]: here the value or values, or it throws.
export const checked = (module) => new Proxy(module, { get: (_, name) => {
  const call = module[name];
  if (!String(name).startsWith('HP_')) return call;
  return (...given) => {
    const [code, ...values] = [call(...given)].flat(1);
    if (code !== module.Result.RESULT_OK) throw new Error(`Havok says ${code.value ?? code}`);
    return values.length > 1 ? values : values[0];
  };
} });
