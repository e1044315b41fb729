import { init } from "stereotrace";
import wasm from "stereotrace/stereotrace_web_bg.wasm";
import { picture } from "./picture.js";

globalThis.pictures = init(wasm)
    .then(picture)
    .catch(String)
    .then((one) => [one]);
