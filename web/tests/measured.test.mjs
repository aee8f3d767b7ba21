// Measured files in the page and in the command.
import assert from "node:assert/strict";
import { existsSync, readFileSync, readdirSync, statSync } from "node:fs";
import { basename, dirname, join } from "node:path";
import { test } from "node:test";
import { commanded, drop, measured, whileTesting } from "./site.mjs";

const tested = whileTesting();

/** Files that the command reads in a moment, as sizes go. */
const LARGEST = 3e6;
const isRead = (path) => existsSync(path) && statSync(path).isFile() && statSync(path).size <= LARGEST && !path.endsWith(".md");
/** What is fitted at the edge of what the data tell moves with the last digits of the samples. */
const OF_STD_ERROR = 1e-2;

function assertSameParameters(mine, theirs, name) {
  assert.deepEqual(Object.keys(mine), Object.keys(theirs), name);
  for (const [key, { value, std_error: error }] of Object.entries(theirs)) {
    if (value === null) continue;
    const apart = Math.abs(mine[key].value - value);
    assert.ok(apart <= Math.max(1e-6 * Math.abs(value), OF_STD_ERROR * (error ?? 0)), `${name} ${key}: ${mine[key].value} and ${value} ± ${error}`);
  }
}

test("measured files have the answers of the command", { skip: !existsSync(measured) && `no measured files at ${measured}` }, async () => {
  const { page, context } = await tested.page();
  // A folder in these holds records of driven motion, which are one curve together and no decay each.
  const folders = ["ringdown", "simulated", "sweep"].map((name) => join(measured, name)).filter((path) => existsSync(path));
  const paths = folders.flatMap((folder) => readdirSync(folder).map((name) => join(folder, name))).filter(isRead).sort();
  let answers = 0;
  for (const path of paths) {
    const name = basename(path);
    const { json, error, command: line } = await drop(page, [{ name, bytes: readFileSync(path) }]);
    if (json) {
      const [mine, theirs] = [json, commanded(line, dirname(path))].map((text) => JSON.parse(text));
      assert.equal(mine.model, theirs.model, name);
      const { time_range_used_s: used = [], ...input } = mine.input;
      const { time_range_used_s: range = [], ...expected } = theirs.input;
      assert.deepEqual(input, expected, name);
      used.forEach((t, i) => assert.ok(Math.abs(t - range[i]) <= 1e-12 * Math.abs(t), `${name}: ${used} and ${range}`));
      assert.deepEqual(mine.warnings.map((w) => w.code), theirs.warnings.map((w) => w.code), name);
      assertSameParameters(mine.parameters ?? {}, theirs.parameters ?? {}, name);
      answers += 1;
    } else {
      assert.ok(error.message.startsWith(name) && !error.message.includes("unexpectedly"), error.message);
    }
  }
  assert.ok(answers > paths.length / 2, `${answers} of ${paths.length} have an answer`);
  await context.close();
});
