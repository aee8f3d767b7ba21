// How long the first answer takes, and the module beside the command: node tests/speed.mjs [--write]
import { spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, writeFileSync } from "node:fs";
import { loadavg, tmpdir } from "node:os";
import { join } from "node:path";
import { command, drop, launch, open, root, serve } from "./site.mjs";

const [, busy] = loadavg();
const ROUNDS = 5;
/** Drops after which the browser has compiled the module for speed. */
const COMPILED = 5;
const ROWS = 50_000;
const folder = mkdtempSync(join(tmpdir(), "slipfit-speed-"));
const file = join(folder, "decay.csv");
const simulate = `simulate decay --frequency-hz 80 --q 2000 --friction-displacement 0.0005 --amplitude 1 --unit mm --duration 25 --rate-hz 2000 --noise-rms 0.002 --seed 1 --out ${file}`;
spawnSync(command, simulate.split(" "), { stdio: "inherit" });

const native = [];
for (let i = 0; i < ROUNDS; i++) {
  const begun = performance.now();
  // One core, and every output that the page makes.
  spawnSync(command, ["ringdown", file, "--json", join(folder, "a.json"), "--html", join(folder, "a.html"), "--csv", join(folder, "a.csv"), "--plot", join(folder, "a.svg"), "--force", "--quiet"], { env: { ...process.env, RAYON_NUM_THREADS: "1" } });
  native.push(performance.now() - begun);
}

const server = await serve();
const browser = await launch();
const first = [];
const later = [];
const compiled = [];
const bytes = readFileSync(file);
for (let i = 0; i < ROUNDS; i++) {
  const { page, context } = await open(browser, server.address);
  first.push((await drop(page, [{ name: "decay.csv", bytes }])).took);
  later.push((await drop(page, [{ name: "again.csv", bytes }])).took);
  for (let k = 0; k < COMPILED + ROUNDS; k++) {
    const { took } = await drop(page, [{ name: `${k}.csv`, bytes }]);
    if (k >= COMPILED) compiled.push(took);
  }
  await context.close();
}
const version = browser.version();
await browser.close();
await server.close();
const best = (times) => Math.min(...times);
const [ours, once, second, again] = [native, first, later, compiled].map(best);
const row = (what, time, asked, met) => `| ${what} | ${time} | ${asked} | ${met} |`;
const met = (is) => (is ? "yes" : "**no**");
const text = `## In the browser

Written by \`node tests/speed.mjs --write\` in \`web/\`: a ring-down of 50 000 rows as CSV, with every output that the page
makes; Chromium ${version.split(".")[0]}, the best of ${ROUNDS}.

| work | takes | asked | met |
|---|--:|--:|---|
${row("the command on one core, from process start", `${ours.toFixed(0)} ms`, "", "")}
${row("the page, from the drop to its first answer", `${once.toFixed(0)} ms`, "≤ 1 s", met(once <= 1000))}
${row("the page, the second file", `${second.toFixed(0)} ms`, "", "")}
${row("the second file, over the command", (second / ours).toFixed(1), "≤ 3", met(second <= 3 * ours))}
${row("the page, a later file", `${again.toFixed(0)} ms`, "", "")}
${row("a later file, over the command", (again / ours).toFixed(1), "≤ 3", met(again <= 3 * ours))}

The page computes two numbers at a time, the command up to eight; the first answer waits for the browser's compiler, which
goes on beside the next ones: later files are those after the first ${COMPILED + 2}.
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
