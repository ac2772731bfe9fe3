// What a program in WebAssembly asks of its system (WASI, preview 1): standard streams, and files in memory that are only read.

const WASI = { done: 0, badFile: 8, notPermitted: 63, noFile: 44, regular: 4, folder: 3, preopened: 3 };

/** Runs a compiled program on `input`; `files` are bytes by path. Returns its exit code and what it wrote: `output` and `errors`. */
async function execute(module, input, files) {
  let memory;
  const view = () => new DataView(memory.buffer);
  const bytes = (at, length) => new Uint8Array(memory.buffer, at, length);
  const text = (at, length) => new TextDecoder().decode(bytes(at, length));
  const word = (at, value) => view().setUint32(at, value, true);
  const written = { 1: [], 2: [] };
  const open = new Map([[0, { content: input, at: 0 }]]);
  let next = WASI.preopened + 1;

  const named = (at, length) => text(at, length).replace(/^(\.?\/)+|^\.$/, "");
  const isFolder = (path) => path === "" || Object.keys(files).some((name) => name.startsWith(`${path}/`));
  const status = (at, kind, size) => {
    bytes(at, 64).fill(0);
    view().setUint8(at + 16, kind);
    view().setBigUint64(at + 32, BigInt(size), true);
    return WASI.done;
  };
  /** The parts of memory that a list of `count` buffers names. */
  const buffers = (list, count) =>
    Array.from({ length: count }, (_, k) => bytes(view().getUint32(list + 8 * k, true), view().getUint32(list + 8 * k + 4, true)));
  const none = (countAt, sizeAt) => {
    word(countAt, 0);
    word(sizeAt, 0);
    return WASI.done;
  };
  const system = {
    environ_get: () => WASI.done,
    environ_sizes_get: none,
    sched_yield: () => WASI.done,
    random_get: (at, length) => {
      crypto.getRandomValues(bytes(at, length));
      return WASI.done;
    },
    proc_exit: (code) => {
      throw { exit: code };
    },
    fd_prestat_get: (file, at) => {
      if (file !== WASI.preopened) return WASI.badFile;
      word(at, 0);
      word(at + 4, 1);
      return WASI.done;
    },
    fd_prestat_dir_name: (_, at) => {
      bytes(at, 1)[0] = 47;
      return WASI.done;
    },
    fd_fdstat_get: (file, at) => {
      bytes(at, 24).fill(0);
      view().setUint8(at, file === WASI.preopened ? WASI.folder : WASI.regular);
      view().setBigUint64(at + 8, 0xffffffffn, true);
      view().setBigUint64(at + 16, 0xffffffffn, true);
      return WASI.done;
    },
    fd_filestat_get: (file, at) => {
      if (!open.has(file)) return file === WASI.preopened ? status(at, WASI.folder, 0) : WASI.badFile;
      return status(at, WASI.regular, open.get(file).content.length);
    },
    fd_read: (file, list, count, readAt) => {
      if (!open.has(file)) return WASI.badFile;
      const source = open.get(file);
      let total = 0;
      for (const buffer of buffers(list, count)) {
        const part = source.content.subarray(source.at, source.at + buffer.length);
        buffer.set(part);
        source.at += part.length;
        total += part.length;
      }
      word(readAt, total);
      return WASI.done;
    },
    fd_write: (file, list, count, writtenAt) => {
      if (!written[file]) return WASI.badFile;
      const parts = buffers(list, count).map((part) => part.slice());
      written[file].push(...parts);
      word(writtenAt, parts.reduce((sum, part) => sum + part.length, 0));
      return WASI.done;
    },
    fd_seek: (file, offset, from, at) => {
      if (!open.has(file)) return WASI.badFile;
      const source = open.get(file);
      source.at = Math.max(0, [0, source.at, source.content.length][from] + Number(offset));
      view().setBigUint64(at, BigInt(source.at), true);
      return WASI.done;
    },
    fd_readdir: (file, at, length, cookie, usedAt) => {
      word(usedAt, 0);
      return WASI.done;
    },
    fd_close: (file) => (open.delete(file) ? WASI.done : WASI.badFile),
    path_filestat_get: (folder, flags, pathAt, length, at) => {
      const path = named(pathAt, length);
      if (Object.hasOwn(files, path)) return status(at, WASI.regular, files[path].length);
      return isFolder(path) ? status(at, WASI.folder, 0) : WASI.noFile;
    },
    path_open: (folder, flags, pathAt, length, how, rights, inherited, mode, at) => {
      const path = named(pathAt, length);
      if (how !== 0) return WASI.notPermitted;
      if (!Object.hasOwn(files, path)) return WASI.noFile;
      open.set(next, { content: files[path], at: 0 });
      word(at, next++);
      return WASI.done;
    },
  };
  const instance = await WebAssembly.instantiate(module, { wasi_snapshot_preview1: system });
  memory = instance.exports.memory;
  let exit = 0;
  try {
    instance.exports._start();
  } catch (end) {
    // a trap: standard error has said why, as where memory is too little
    exit = end.exit ?? 134;
  }
  const joined = async (parts) => await new Blob(parts).text();
  return { exit, output: await joined(written[1]), errors: await joined(written[2]) };
}

