// Holds .glb files against Khronos' glTF validator: no errors and no warnings. Usage: node tests/validate_gltf.js FILE...
// Exit status: 0 all valid, 1 not, 77 the validator is not installed (./dev deps installs it), which ctest counts as skipped.
"use strict";

const fs = require("fs");

let validator;
try {
  validator = require("gltf-validator");
} catch {
  console.log("skipped: the npm package gltf-validator is not installed");
  process.exit(77);
}

// maxIssues 0 = no limit: past a limit the validator stops counting, and notes would hide errors.
async function check(path) {
  const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(path)), { maxIssues: 0 });
  const { numErrors, numWarnings, numInfos, messages } = report.issues;
  console.log(`${path}: ${numErrors} errors, ${numWarnings} warnings, ${numInfos} notes`);
  for (const { severity, code, message, pointer } of messages) {
    if (severity < 2) console.log(`  ${severity === 0 ? "error" : "warning"} ${code} ${pointer}: ${message}`);
  }
  return numErrors === 0 && numWarnings === 0;
}

async function main() {
  const paths = process.argv.slice(2);
  if (paths.length === 0) throw new Error("no files to validate");
  let good = true;
  for (const path of paths) good = (await check(path)) && good;
  process.exit(good ? 0 : 1);
}

main().catch((error) => {
  console.error(`${error.message ?? error}`);
  process.exit(1);
});
