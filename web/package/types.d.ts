/** Three numbers: a position, a direction or a colour (red, green and blue, linear light). */
export type Vector = readonly [number, number, number];

/** Whose view it is. */
export type Eye = "left" | "right";

/** A method by its name: one of `methods()`, or another that docs/DESIGN.md names. */
export type MethodName =
    | "auto" | "naive" | "ideal" | "atomic" | "atomic-edges" | "buffer" | "buffer-2e" | "es-isler" | "adelson-hodges"
    | "bracket" | "verified" | "bracket-rays" | (string & {});

/** A kind of anaglyph by its name: one of `anaglyphs()`. */
export type AnaglyphName = "dubois" | "dubois-lcd" | "grey" | "colour" | "half-colour" | "green-magenta" | "amber-blue";

/** Two views in one picture: one of `packings()`. */
export type PackingName =
    | "side-by-side" | "half-side-by-side" | "cross-eyed" | "top-bottom" | "half-top-bottom" | "row-interlaced"
    | "column-interlaced" | "checkerboard";

/** Two eyes that look through one screen rectangle (off-axis projection). World units unless something else is said. */
export interface Camera {
    /** The midpoint between the eyes. */
    eye: Vector;
    /** A point that is looked at. */
    target: Vector;
    /** The direction that is up in the picture; +y where nothing is said. */
    up?: Vector;
    /** Width and height in pixels; 640x480 where nothing is said. */
    size?: readonly [number, number];
    /** The vertical field of view in degrees; 45 where nothing is said. */
    fov?: number;
    /** From the eyes to the plane of zero parallax; to the target where nothing is said. `Infinity` makes parallel cameras. */
    screenDistance?: number;
    /** The distance between the eyes; a thirtieth of the target's distance where nothing is said. */
    interaxial?: number;
    /** The same in pixels: the parallax at infinity. */
    interaxialPixels?: number;
    /** Whether the eyes are turned towards each other. Both views are then traced, whatever the method. */
    toeIn?: boolean;
}

/** How a picture is rendered. */
export interface RenderOptions {
    /** How the second eye is made; `"auto"` where nothing is said. */
    method?: MethodName;
    /** Samples a pixel: 1, 4, 9, 16, 25, 36, 49 or 64; 1 where nothing is said. */
    samples?: number;
    /** How samples are weighed: `"box"` where nothing is said. */
    filter?: "box" | "tent" | "gauss";
    /** Count BVH nodes and primitive tests, for `Statistics.secondEye`: slower. */
    count?: boolean;
    /** How often rays are mirrored or refracted, 0 to 8; 5 where nothing is said. */
    bounces?: number;
    /** Rays to each light that is not a point, 1 to 32; 16 where nothing is said. */
    shadowRays?: number;
    /** Light surfaces by the sky, by so many rays, 1 to 32, in place of ambient light. */
    skyRays?: number;
    /** Keep ambient light off by what stands near: rays, 1 to 32, and how far they go in world units. */
    ambientOcclusion?: { rays: number; radius: number };
    /** Stops by which the picture is brighter, -64 to 64. */
    exposure?: number;
    /** What becomes of what is too bright; `"clamp"` where nothing is said. */
    tone?: "clamp" | "filmic";
    /** Of the random numbers of soft light: the same seed makes the same picture. */
    seed?: number;
    /** Ends the work with an `AbortError` after the rows that the device is at. */
    signal?: AbortSignal;
    /** Called with the share of rows that are done, 0 to 1. */
    onProgress?: (done: number) => void;
}

/** Numbers of rays by kind. */
export interface Rays {
    primary: number;
    verification: number;
    shadow: number;
    secondary: number;
}

/** What a pair cost. */
export interface Statistics {
    /** The method that made it. */
    method: string;
    /** Why `"auto"` chose that. */
    choice?: string;
    /** Whether the adapter ended kernels early, and the frame was rendered in smaller steps. */
    inSteps: boolean;
    /** Share of the right pixels that were traced, 0 to 1. */
    retracedShare: number;
    /** The right view's cost over the left one's by counters; only with `RenderOptions.count`. */
    secondEye?: number;
    left: Rays;
    right: Rays;
    /** Time of each pass on the device, in order; undefined where the browser has no timestamps. */
    passes?: { name: string; ms: number }[];
}

/** How far a view is from another. */
export interface Difference {
    /** Pixels of the same colour, percent. */
    identicalPercent: number;
    /** Pixels that show another surface, percent. */
    wrongSurfacePercent: number;
    /** Peak signal-to-noise ratio, dB; `Infinity` where nothing differs. */
    psnr: number;
    /** A thousandth of the pixels are farther apart than this, in steps of 255. */
    p999: number;
    /** Of the pixels that differ, the mean distance of colours in steps of 255. */
    meanDifference: number;
    /** Largest error of any pixel's parallax, pixels. */
    largestParallaxError: number;
}

/** What there is in a scene. */
export interface SceneInfo {
    triangles: number;
    primitives: number;
    objects: number;
    materials: number;
    textures: number;
    lights: number;
    /** Low and high corner in world units; undefined of an empty scene. */
    bounds?: [[number, number, number], [number, number, number]];
}

/** A surface. */
export interface Material {
    /** Diffuse reflectance; 0.7 where nothing is said. */
    albedo?: Vector;
    /** Colour of highlights; of mirrors and glass the share that they reflect. */
    specular?: Vector;
    /** Phong's exponent; 30 where nothing is said. */
    exponent?: number;
    /** What it gives off by itself. */
    emission?: Vector;
    /** The share of what is behind it that it hides, 0 to 1. */
    opacity?: number;
    /** The number of a texture that the albedo is multiplied by. */
    texture?: number;
    /** The number of a texture where whose alpha is below a half there is no surface. */
    cutout?: number;
    finish?: "matte" | "mirror" | "glass";
    /** Index of refraction of glass; 1.5 where nothing is said. */
    index?: number;
}

/** A light: a point, or with a radius a ball, whose shadows have a penumbra. */
export interface Light {
    position: Vector;
    /** What it adds to a white surface that faces it. */
    intensity: Vector;
    radius?: number;
}

/** Triangles. Lists are of vertices, as glTF, three.js and others have them. */
export interface Mesh {
    /** World positions, three numbers a vertex. */
    positions: Float32Array;
    /** Three vertices a triangle; without them each three vertices are one. */
    indices?: Uint32Array;
    /** Unit normals, three numbers a vertex. */
    normals?: Float32Array;
    /** Texture coordinates, two numbers a vertex: (0, 0) is a texture's lower left corner, (1, 1) the upper right. */
    uvs?: Float32Array;
    /** What the albedo is multiplied by, three numbers a vertex, linear light. */
    colors?: Float32Array;
    /** The number of a material; the grey one, 0, where nothing is said. */
    material?: number;
    name?: string;
    /** Makes normals, smooth across edges of less than so many degrees. */
    creaseAngle?: number;
}
