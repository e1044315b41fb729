import { picture } from "./picture.js";

picture().then(postMessage, (error) => postMessage(String(error)));
