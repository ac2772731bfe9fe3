// Workers: the program runs beside the page, which stays responsive, and on several processors.

const WORKERS = Math.min(navigator.hardwareConcurrency || 1, 8);

/** Runs the program as [execute] does, one request at a time: in a worker of its own, or in the page where there are none. */
function runner() {
  const answer = "onmessage = async ({ data }) => postMessage(await execute(data.module, data.input, data.files));";
  const script = `"use strict";const WASI = ${JSON.stringify(WASI)};${execute}${answer}`;
  let worker;
  try {
    worker = new Worker(URL.createObjectURL(new Blob([script], { type: "text/javascript" })));
  } catch {
    return execute;
  }
  return (module, input, files) =>
    new Promise((done, failed) => {
      worker.onmessage = ({ data }) => done(data);
      worker.onerror = (event) => failed(new Error(event.message || "the browser does not run a worker"));
      worker.postMessage({ module, input, files });
    });
}

const idle = [];
const waiting = [];
let runners = 0;

/** Asks the program as soon as a worker is idle: the text it prints. */
async function askBeside(request, files) {
  program ??= compiled();
  const module = await program;
  if (!idle.length && runners < WORKERS) {
    runners += 1;
    idle.push(runner());
  }
  const run = idle.pop() ?? (await new Promise((free) => waiting.push(free)));
  try {
    return printed(await run(module, encoded(request), files));
  } finally {
    const next = waiting.shift();
    if (next) next(run);
    else idle.push(run);
  }
}
