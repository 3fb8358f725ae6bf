// The memory of a module: texts and numbers go in and out, and failed calls become errors.

const scratchBytes = 256;

export class Memory {
  constructor(module) {
    this.module = module;
    this.scratch = module._malloc(scratchBytes);
  }

  // The views move when the memory grows, so that nobody keeps them.
  get u8() { return this.module.HEAPU8; }
  get u32() { return this.module.HEAPU32; }
  get i32() { return this.module.HEAP32; }
  get f64() { return this.module.HEAPF64; }

  call(name, ...values) { return this.module[name](...values); }
  text(at) { return this.module.UTF8ToString(at); }

  /** use(address) with room for so many bytes. */
  withBytes(count, use) {
    const at = this.module._malloc(count || 1);
    if (at === 0) throw new Error('psim: out of memory');
    try {
      return use(at);
    } finally {
      this.module._free(at);
    }
  }

  withText(text, use) {
    const bytes = this.module.lengthBytesUTF8(text) + 1;
    return this.withBytes(bytes, (at) => {
      this.module.stringToUTF8(text, at, bytes);
      return use(at);
    });
  }

  /** use(address) with room for a few numbers; calls within it overwrite them. */
  numbers(count, use) {
    if (8 * count > scratchBytes) return this.withBytes(8 * count, use);
    return use(this.scratch);
  }

  /** An address that a function of scenes gave; 0 is an error with its line. */
  need(address) {
    if (address === 0) throw new Error(`psim: ${this.text(this.call('_psim_flat_error'))}`);
    return address;
  }

  /** A result of the C API: below 0 is an error with the world's line, 1 is nothing. */
  check(result, world) {
    if (result >= 0) return result === 0;
    const line = this.withBytes(512, (at) => (this.call('_psim_last_error', world, at, 512), this.text(at)));
    throw new Error(`psim: ${line || `error ${result}`}`);
  }
}
