// What the validator of the Khronos Group reports of a file, as JSON.
//
// validate_glb.js FILE, with its packages at NODE_PATH.

const fs = require("fs");
const validator = require("gltf-validator");

validator
  .validateBytes(new Uint8Array(fs.readFileSync(process.argv[2])), { maxIssues: 100 })
  .then((report) => console.log(JSON.stringify(report)));
