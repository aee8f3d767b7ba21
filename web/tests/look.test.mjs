// How the page looks at every width.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";
import { test } from "node:test";
import { settled, shots, whileTesting } from "./site.mjs";

const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");

const tested = whileTesting();

for (const [width, scheme] of [[360, "light"], [1440, "dark"], [1440, "light"], [360, "dark"]]) {
  test(`at ${width} px, ${scheme}: nothing overflows, axe finds nothing`, async () => {
    const { page, context } = await tested.page({ viewport: { width, height: 900 }, colorScheme: scheme });
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
