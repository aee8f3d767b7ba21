// How long the first answer takes, and the module beside the command: node tests/speed.mjs
import { spawnSync } from "node:child_process";
import { mkdtempSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { command, drop, launch, open, serve } from "./site.mjs";

const ROUNDS = 5;
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
const { readFileSync } = await import("node:fs");
const bytes = readFileSync(file);
for (let i = 0; i < ROUNDS; i++) {
  const { page, context } = await open(browser, server.address);
  first.push((await drop(page, [{ name: "decay.csv", bytes }])).took);
  later.push((await drop(page, [{ name: "again.csv", bytes }])).took);
  await context.close();
}
await browser.close();
await server.close();
const best = (times) => Math.min(...times).toFixed(0);
console.log(`${ROWS} rows: command on one core ${best(native)} ms, page at the first file ${best(first)} ms, at the next ${best(later)} ms`);
writeFileSync(join(folder, "done"), "");
