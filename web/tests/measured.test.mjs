// Measured files in the page and in the command.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { existsSync, readFileSync, readdirSync } from "node:fs";
import { basename, dirname, join } from "node:path";
import { test } from "node:test";
import { command, commanded, drop, measured, whileTesting } from "./site.mjs";

const tested = whileTesting();

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

/** The files of a folder and those below it, in order; notes about them left out. */
function filesOf(folder) {
  const below = (entry) => (entry.isDirectory() ? filesOf(join(folder, entry.name)) : [join(folder, entry.name)]);
  return readdirSync(folder, { withFileTypes: true }).flatMap(below).filter((path) => !path.endsWith(".md")).sort();
}

test("every measured file has the answer of the command", { skip: !existsSync(measured) && `no measured files at ${measured}` }, async () => {
  const { page, context } = await tested.page();
  const paths = filesOf(measured);
  const refused = [];
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
    } else {
      assert.ok(error.message.startsWith(name) && !error.message.includes("unexpectedly"), error.message);
      refused.push([path, error.message]);
    }
  }
  // What the page refuses, the command refuses for the same reason.
  const words = (text) => text.replace(/\s+/g, " ");
  for (const [path, message] of refused) {
    const { status, stderr } = spawnSync(command, ["ringdown", basename(path)], { cwd: dirname(path), encoding: "utf8" });
    assert.equal(status, 2, path);
    assert.ok(words(stderr).includes(words(message)), `${message} and ${stderr}`);
  }
  assert.ok(refused.length < paths.length / 4, `${refused.length} of ${paths.length} are refused`);
  await context.close();
});
