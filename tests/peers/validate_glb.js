// What the validator of the Khronos Group says of a file, as JSON.
//
// validate_glb.js FILE, with its packages where NODE_PATH says.

const fs = require("fs");
const validator = require("gltf-validator");

validator
  .validateBytes(new Uint8Array(fs.readFileSync(process.argv[2])), { maxIssues: 100 })
  .then((report) => console.log(JSON.stringify(report)));
