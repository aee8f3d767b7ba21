// The core, away from the thread that draws. One call at a time; whoever cannot wait ends the worker.
const module = self.name === "columns" ? "./slipfit_wasm_columns.js" : "./slipfit_wasm.js";
const ready = import(module).then(async (slipfit) => {
  await slipfit.default();
  return slipfit;
});

self.onmessage = async ({ data: { id, call, args } }) => {
  try {
    const slipfit = await ready;
    self.postMessage({ id, text: slipfit[call](...args) });
  } catch (error) {
    // A panic ends the instance: the page starts another.
    self.postMessage({ id, broken: String(error) });
  }
};
