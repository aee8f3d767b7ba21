// How the page looks at every width, and what measured files give.
import assert from "node:assert/strict";
import { existsSync, readFileSync, readdirSync, statSync } from "node:fs";
import { createRequire } from "node:module";
import { basename, dirname, join } from "node:path";
import { after, before, test } from "node:test";
import { commanded, drop, launch, measured, open, serve, settled, shots } from "./site.mjs";

const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");

let server;
let browser;
before(async () => {
  server = await serve();
  browser = await launch();
});
after(async () => {
  await browser?.close();
  await server?.close();
});

for (const [width, scheme] of [[360, "light"], [1440, "dark"], [1440, "light"], [360, "dark"]]) {
  test(`at ${width} px, ${scheme}: nothing overflows, axe finds nothing`, async () => {
    const { page, context } = await open(browser, server.address, { viewport: { width, height: 900 }, colorScheme: scheme });
    // Injected by the debugger, past the page's own policy.
    const violations = async () => {
      await page.evaluate(axe);
      const found = await page.evaluate(() => window.axe.run());
      return found.violations.map((v) => `${v.id}: ${v.nodes.map((n) => n.html.slice(0, 120)).join(" | ")}`);
    };
    const fits = () => page.evaluate(() => document.documentElement.scrollWidth <= innerWidth);
    assert.deepEqual(await violations(), []);
    for (const [key, name] of [["pendulum", "classroom_pendulum.csv"], ["beat", "two_modes.csv"], ["resonance", "tuning_fork_9nN_sweep.csv"]]) {
      await page.click(`#example-${key}`);
      await settled(page, name);
      await page.locator("summary").click();
      await page.screenshot({ path: join(shots, `${key}-${width}-${scheme}.png`), fullPage: true });
      assert.ok(await fits(), `${key} overflows`);
      assert.deepEqual(await violations(), [], key);
    }
    for (const tab of ["measure", "simulate"]) {
      await page.click(`#tab-${tab}`);
      if (tab === "simulate") await page.waitForSelector("#simulate .u-legend");
      assert.ok(await fits(), `${tab} overflows`);
      assert.deepEqual(await violations(), [], tab);
      await page.screenshot({ path: join(shots, `${tab}-${width}-${scheme}.png`), fullPage: true });
    }
    await context.close();
  });
}

/** Files that the command reads in a moment, as sizes go. */
const LARGEST = 3e6;
const isFile = (path) => existsSync(path) && statSync(path).isFile();

test("measured files have the answers of the command", { skip: !existsSync(measured) && `no measured files at ${measured}` }, async () => {
  const { page, context } = await open(browser, server.address);
  const found = readdirSync(measured, { recursive: true }).map((name) => join(measured, name)).filter(isFile);
  const small = found.filter((path) => statSync(path).size <= LARGEST && /\.(csv|txt|dat|wav|xlsx?|mat|npy|tsv)$/i.test(path)).sort();
  // Every eighth: the whole of them is what the command's own tests read.
  const chosen = small.filter((_, i) => i % 8 === 0);
  let answers = 0;
  for (const path of chosen) {
    const name = basename(path);
    const { json, error, command: line } = await drop(page, [{ name, bytes: readFileSync(path) }]);
    if (json) {
      // What is fitted at the edge of what the data tell moves with the last digits of the samples.
      const [mine, theirs] = [json, commanded(line, dirname(path))].map((text) => JSON.parse(text));
      assert.equal(mine.model, theirs.model, name);
      assert.deepEqual(mine.input, theirs.input, name);
      assert.deepEqual(mine.warnings.map((w) => w.code), theirs.warnings.map((w) => w.code), name);
      answers += 1;
    } else {
      assert.ok(error.message.startsWith(name) && !error.message.includes("unexpectedly"), error.message);
    }
  }
  assert.ok(answers > 5, `${answers} of ${chosen.length} have an answer`);
  await context.close();
});
