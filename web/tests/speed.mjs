// How long the first answer takes, and the module beside the command: node tests/speed.mjs [--write]
import { spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, writeFileSync } from "node:fs";
import { loadavg, tmpdir } from "node:os";
import { join } from "node:path";
import { command, drop, launch, open, root, serve } from "./site.mjs";

const [, busy] = loadavg();
const ROUNDS = 15;
/** From the page's being ready to the first drop: less than a person needs to choose a file. */
const SETTLED_MS = 2000;
/** From an answer to the next drop: it is laid out and painted by then. */
const PAINTED_MS = 300;
/** Drops after which the browser has compiled the module for speed. */
const COMPILED = 5;
const ROWS = 50_000;
const folder = mkdtempSync(join(tmpdir(), "slipfit-speed-"));
const file = join(folder, "decay.csv");
const simulate = `simulate decay --frequency-hz 80 --q 2000 --friction-displacement 0.0005 --amplitude 1 --unit mm --duration 25 --rate-hz 2000 --noise-rms 0.002 --seed 1 --out ${file}`;
spawnSync(command, simulate.split(" "), { stdio: "inherit" });

/** The command on one core, with these outputs besides its report on the screen. */
function commanded(...endings) {
  const flags = { json: "--json", svg: "--plot", html: "--html", csv: "--csv" };
  const outputs = endings.flatMap((ending) => [flags[ending], join(folder, `a.${ending}`)]);
  const begun = performance.now();
  spawnSync(command, ["ringdown", file, ...outputs, "--force"], { env: { ...process.env, RAYON_NUM_THREADS: "1" } });
  return performance.now() - begun;
}
const [native, nativeAll] = [[], []];
for (let i = 0; i < ROUNDS; i++) {
  // What the page makes with an answer: sentence, tables, JSON and panels; then what its buttons make as well.
  native.push(commanded("json", "svg"));
  nativeAll.push(commanded("json", "svg", "html", "csv"));
}

/** Makes what the buttons of the answer make, but for what it has. */
const demanded = (page) =>
  page.evaluate(async () => {
    const begun = performance.now();
    for (const what of ["html", "svg", "csv"]) await window.slipfit.output(what);
    return performance.now() - begun;
  });

const server = await serve();
const browser = await launch();
const first = [];
const later = [];
const compiled = [];
const asked = [];
const bytes = readFileSync(file);
for (let i = 0; i < ROUNDS; i++) {
  const { page, context } = await open(browser, server.address);
  await page.waitForTimeout(SETTLED_MS);
  first.push((await drop(page, [{ name: "decay.csv", bytes }])).took);
  await page.waitForTimeout(PAINTED_MS);
  later.push((await drop(page, [{ name: "again.csv", bytes }])).took);
  for (let k = 0; k <= COMPILED; k++) {
    await page.waitForTimeout(PAINTED_MS);
    const { took } = await drop(page, [{ name: `${k}.csv`, bytes }]);
    if (k >= COMPILED) compiled.push(took);
    const making = await demanded(page);
    if (k >= COMPILED) asked.push(making);
  }
  await context.close();
}
const version = browser.version();
await browser.close();
await server.close();
const best = (times) => Math.min(...times);
const [ours, all, once, second, again, more] = [native, nativeAll, first, later, compiled, asked].map(best);
const row = (what, time, limit, met) => `| ${what} | ${time} | ${limit} | ${met} |`;
const met = (is) => (is ? "yes" : "**no**");
const ms = (time) => `${time.toFixed(0)} ms`;
const text = `## In the browser

Written by \`node tests/speed.mjs --write\` in \`web/\`: a ring-down of 50 000 rows as CSV; Chromium ${version.split(".")[0]}, the best of ${ROUNDS}.

| work | takes | asked | met |
|---|--:|--:|---|
${row("the command on one core, from process start, with JSON and figure", ms(ours), "", "")}
${row("the page, from the drop to its first answer", ms(once), "≤ 1 s", met(once <= 1000))}
${row("the page, the second file", ms(second), "", "")}
${row("the second file, over the command", (second / ours).toFixed(1), "≤ 3", met(second <= 3 * ours))}
${row("the page, a later file", ms(again), "", "")}
${row("a later file, over the command", (again / ours).toFixed(1), "≤ 3", met(again <= 3 * ours))}
${row("report, figure and CSV from the buttons of a later file", ms(more), "", "")}
${row("a later file and these, over the command that writes them too", ((again + more) / all).toFixed(1), "≤ 3", met(again + more <= 3 * all))}

A file's time is from the drop, which comes when the answer before it is painted, to the answer in the page, before the
browser lays it out and paints it: the bytes read, sentence, tables, warnings, JSON, the record to zoom in and all
panels. Report, figure as a file and CSV are made when their buttons are pressed. The page computes two numbers at a
time, the command up to eight. Once it is loaded, and until a file comes, it analyses a small record of its own, so that
the browser compiles for speed what the first file needs; the rest is compiled beside the next ones: later files are
those after the first ${COMPILED + 2}.
`;
console.log(text);
if (process.argv.includes("--write")) {
  // Before this program had a share in it.
  if (busy > 0.7) throw new Error(`nothing written: with ${busy} processes at work the times mean little`);
  writeFileSync(join(root, "validation/src/bench/browser.md"), text);
  const page = join(root, "docs/benchmarks.md");
  const before = readFileSync(page, "utf8").split("## In the browser")[0];
  writeFileSync(page, `${before.trimEnd()}\n\n${text}`);
}
