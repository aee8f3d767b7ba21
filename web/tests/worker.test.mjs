// The worker that holds the core: kept while it is of use, ended where someone cannot wait.
import assert from "node:assert/strict";
import { test } from "node:test";
import { bytesOf, drop, settled, whileTesting } from "./site.mjs";

const tested = whileTesting();

test("one worker answers file after file, and another follows a large one", async () => {
  const { page, context } = await tested.page();
  const [first] = page.workers();
  for (const name of ["classroom_pendulum.csv", "tuning_fork_9nN_sweep.csv"]) {
    const { error } = await drop(page, [{ name, bytes: bytesOf(name) }]);
    assert.equal(error, null);
    assert.deepEqual(page.workers(), [first]);
  }
  const large = Buffer.alloc(51e6, "no table\n");
  assert.ok((await drop(page, [{ name: "large.csv", bytes: large }])).error);
  const { error } = await drop(page, [{ name: "classroom_pendulum.csv", bytes: bytesOf("classroom_pendulum.csv") }]);
  assert.equal(error, null);
  assert.ok(page.workers().length === 1 && page.workers()[0] !== first);
  await context.close();
});

test("a file of 300 MB is read and can be cancelled, one beyond a page is refused", async () => {
  const { page, context } = await tested.page();
  const dropped = (megabytes, name) =>
    page.evaluate(
      ([size, called]) => {
        const rows = `${"0.12345678\n".repeat(95_000)}`;
        const file = new File(["x (m)\n", ...Array(Math.ceil((size * 1e6) / rows.length)).fill(rows)], called);
        const transfer = new DataTransfer();
        transfer.items.add(file);
        dispatchEvent(new DragEvent("drop", { dataTransfer: transfer, cancelable: true }));
        return file.size;
      },
      [megabytes, name],
    );
  assert.ok((await dropped(300, "large.csv")) >= 300e6);
  await page.waitForSelector("#working:not([hidden])", { timeout: 60_000 });
  await page.click("#cancel");
  const { error } = await settled(page, "large.csv");
  assert.equal(error.message, "Cancelled.");
  await page.evaluate(() => Object.defineProperty(File.prototype, "size", { get: () => 701e6 }));
  const refused = await drop(page, [{ name: "larger.csv", bytes: bytesOf("classroom_pendulum.csv") }]);
  assert.ok(refused.error.message.startsWith("larger.csv: 701 MB is more than a page can hold"), refused.error.message);
  await context.close();
});

test("two drops in a row leave the answer of the second", async () => {
  const { page, context } = await tested.page();
  const first = drop(page, [{ name: "tuning_fork_9nN_waveform.csv", bytes: bytesOf("tuning_fork_9nN_waveform.csv") }]).catch(() => null);
  const { json } = await drop(page, [{ name: "classroom_pendulum.csv", bytes: bytesOf("classroom_pendulum.csv") }]);
  assert.equal(JSON.parse(json).input.path, "classroom_pendulum.csv");
  await Promise.race([first, new Promise((done) => setTimeout(done, 3000))]);
  assert.equal(await page.locator("#sentence").count(), 1);
  await context.close();
});

test("a long analysis is cancelled in the middle", async () => {
  const { page, context } = await tested.page();
  await page.evaluate(() => {
    const rows = ["time (s),x (m)"];
    for (let i = 0; i < 600_000; i++) rows.push(`${i / 1000},${(Math.exp(-i / 2e5) * Math.cos(0.2 * i)).toFixed(6)}`);
    // From inside: a click of the driver may come after the answer.
    const said = document.getElementById("working-text");
    const begun = new MutationObserver(() => said.textContent.startsWith("Analysing") && document.getElementById("cancel").click());
    begun.observe(said, { childList: true });
    window.slipfit.take("long.csv", new TextEncoder().encode(rows.join("\n"))).then(() => begun.disconnect());
  });
  const { error } = await settled(page, "long.csv");
  assert.equal(error.message, "Cancelled.");
  const { error: none } = await drop(page, [{ name: "classroom_pendulum.csv", bytes: bytesOf("classroom_pendulum.csv") }]);
  assert.equal(none, null);
  await context.close();
});
