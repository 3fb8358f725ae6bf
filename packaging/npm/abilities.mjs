// What this browser or Node can run. Each question is a module of a few bytes that either is valid or is not.

const header = [0x00, 0x61, 0x73, 0x6d, 1, 0, 0, 0];
const accepts = (...sections) => {
  try {
    return WebAssembly.validate(new Uint8Array([...header, ...sections]));
  } catch {
    return false; // no WebAssembly at all
  }
};
const type = [1, 4, 1, 0x60, 0, 0]; // () -> ()
const one = [3, 2, 1, 0]; // one function of it

export function abilities() {
  return {
    // i32.const 0, i8x16.splat, drop
    simd: accepts(...type, ...one, 10, 9, 1, 7, 0, 0x41, 0, 0xfd, 0x0f, 0x1a, 0x0b),
    // try, catch_all, end
    exceptions: accepts(...type, ...one, 10, 8, 1, 6, 0, 0x06, 0x40, 0x19, 0x0b, 0x0b),
    // Shared memory. A page has it only if it is served with the headers COOP and COEP.
    threads:
      typeof SharedArrayBuffer === 'function' &&
      globalThis.crossOriginIsolated !== false &&
      accepts(5, 4, 1, 3, 1, 1),
  };
}
