/** Three numbers: a position, a direction or a colour (red, green and blue, linear light). */
export type Vector = readonly [number, number, number];

/** Eye of a view. */
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

/** An output of a view: one of `channels()`. Pairs of this package have no ground truth. */
export type ChannelName =
    | "color" | "linear" | "albedo" | "depth" | "disparity" | "primitive" | "object" | "source" | "shadow_source"
    | "cost" | (string & {});

/**
 * Two eyes that look through one screen rectangle (off-axis projection). The world is right-handed with y up. Lengths
 * are in world units.
 */
export interface Camera {
    /** Midpoint between the eyes. */
    eye: Vector;
    /** Point that the camera looks at. */
    target: Vector;
    /** Up direction of the picture. Default +y. */
    up?: Vector;
    /** Width and height in pixels. Default 640x480. */
    size?: readonly [number, number];
    /** Vertical field of view in degrees. Default 45. */
    fov?: number;
    /**
     * Distance from the eyes to the screen, the plane of zero parallax (convergence distance). Default the target's
     * distance. `Infinity` makes parallel cameras.
     */
    screenDistance?: number;
    /** Distance between the eyes (baseline). Default a thirtieth of the target's distance. */
    interaxial?: number;
    /** Distance between the eyes in pixels: the parallax at infinity. */
    interaxialPixels?: number;
    /** Whether the eyes turn towards each other. Every method then traces both views. */
    toeIn?: boolean;
    /**
     * Makes equirectangular pictures of so many degrees (omnidirectional stereo), whose vertical axis is `up`. They have
     * no field of view and no screen, and `interaxial` must be given in world units or left out.
     */
    projection?: 360 | 180;
    /** Elevations in degrees between which the eyes of an equirectangular pair approach each other. Default [60, 75]. */
    poleMerge?: readonly [number, number] | boolean;
}

/** Options of rendering. */
export interface RenderOptions {
    /** Method that makes the second eye. Default `"auto"`. */
    method?: MethodName;
    /** Samples per pixel, for antialiasing: 1, 4, 9, 16, 25, 36, 49 or 64. Default 1. */
    samples?: number;
    /** Weights of samples. Default `"box"`. */
    filter?: "box" | "tent" | "gauss";
    /** Whether to jitter the sample grid, so that near-vertical edges get more levels. Default true. */
    jitter?: boolean;
    /** Adaptive antialiasing in place of `samples`: a tolerance in 8-bit values, and 2 to 5 levels. */
    adaptive?: { tolerance: number; levels: number } | null;
    /** Whether to count BVH nodes and primitive tests for `Statistics.secondEye`, which is slower. */
    count?: boolean;
    /** Maximum number of reflections and refractions along a ray, 0 to 8. Default 5. */
    bounces?: number;
    /** Rays to each light that is not a point, 1 to 32. Default 16. */
    shadowRays?: number;
    /** Number of rays, 1 to 32, by which the sky lights surfaces, in place of ambient light. */
    skyRays?: number | null;
    /** Ambient occlusion: rays, 1 to 32, and radius for occluders in world units. */
    ambientOcclusion?: { rays: number; radius: number } | null;
    /** Soft light that the second eye reuses: of points that are fully lit or shadowed, or of penumbrae too. */
    penumbra?: "exact" | "shared";
    /** Light by other surfaces: none but in mirrors and glass, or global illumination by paths per pixel and bounces. */
    lighting?: "direct" | "paths" | `paths=${number}` | `paths=${number}:${number}`;
    /** Whether to remove noise from light by paths. Default false. */
    denoise?: boolean;
    /** Whether each view has its own random numbers. Default false. */
    noiseByView?: boolean;
    /** How traced views find their closest hits. Default `"rays"`. */
    visibility?: "rays" | "t-buffer";
    /** Shadow buffers in place of shadow rays to point lights: rows of a table, and a rule. */
    shadowBuffer?: { rows: number; rule: "object" | "depth" | "hybrid" } | null;
    /** Memory for samples of earlier frames in MiB, by which the next frame finds first hits and light. */
    history?: number | null;
    /** Exposure in stops, -64 to 64. */
    exposure?: number;
    /** Tone mapping: clamp values above 1, or map all values by a filmic curve. Default `"clamp"`. */
    tone?: "clamp" | "filmic";
    /** Seed of the random numbers for soft light and jitter. The same seed makes the same picture. */
    seed?: number;
    /** Aborts rendering with the signal's reason, by default an `AbortError`, after the rows that the device renders. */
    signal?: AbortSignal;
    /** Called with the share of finished rows, 0 to 1. */
    onProgress?: (done: number) => void;
}

/** Numbers of rays by kind. */
export interface Rays {
    primary: number;
    verification: number;
    shadow: number;
    secondary: number;
}

/** Cost of a pair. */
export interface Statistics {
    /** Method that made the pair. */
    method: string;
    /** Reasons for the choice of `"auto"`. */
    choice?: string;
    /** Whether the adapter ended kernels early, and the frame was rendered in smaller steps. */
    inSteps: boolean;
    /** Share of right pixels that were traced, 0 to 1. */
    retracedShare: number;
    /** Cost of the right view relative to the left view, by counters; only with `RenderOptions.count`. */
    secondEye?: number;
    left: Rays;
    right: Rays;
    /** Time of each pass on the device, in order; undefined if the browser has no timestamps. */
    passes?: { name: string; ms: number }[];
}

/** Difference between two views. */
export interface Difference {
    /** Pixels with the same colour, in percent. */
    identicalPercent: number;
    /** Pixels that show another surface, in percent. */
    wrongSurfacePercent: number;
    /** Peak signal-to-noise ratio in dB; `Infinity` for identical views. */
    psnr: number;
    /** Difference that 99.9% of the pixels do not exceed, in 8-bit steps. */
    p999: number;
    /** Mean difference of colours in 8-bit steps, over the pixels that differ. */
    meanDifference: number;
    /** Largest parallax error of any pixel, in pixels. */
    largestParallaxError: number;
}

/** Contents of a scene. */
export interface SceneInfo {
    triangles: number;
    primitives: number;
    objects: number;
    materials: number;
    textures: number;
    lights: number;
    /** Whether materials are physically based, so that light by paths shows more of them. */
    physicallyBased: boolean;
    /** Whether materials emit light, which paths find. */
    emits: boolean;
    /** Low and high corner of the bounding box in world coordinates; undefined for an empty scene. */
    bounds?: [[number, number, number], [number, number, number]];
}

/** A surface. Colours are linear RGB. */
export interface Material {
    /** Diffuse reflectance. Default 0.7. */
    albedo?: Vector;
    /** Colour of highlights, or reflectance of mirrors and glass. */
    specular?: Vector;
    /** Phong's exponent. Default 30. */
    exponent?: number;
    /** Emitted radiance. */
    emission?: Vector;
    /** Share of the background that the surface hides, 0 to 1. */
    opacity?: number;
    /** Whether the alpha of `texture` multiplies the opacity. Default false. */
    alphaBlend?: boolean;
    /** Id of a texture that multiplies the albedo. */
    texture?: number;
    /** Id of a texture that cuts the surface out where its alpha is below a half. */
    cutout?: number;
    finish?: "matte" | "mirror" | "glass";
    /** Refractive index of glass. Default 1.5. */
    index?: number;
    /** A physically based surface, in place of `albedo`, `specular`, `exponent` and `finish`. */
    surface?: Surface;
}

/**
 * A physically based surface (metallic-roughness, as glTF 2.0 has it), which light by paths shows. Direct light shows
 * Phong's approximation of it. Textures are ids; they multiply the values of these names.
 */
export interface Surface {
    /** Diffuse reflectance of a dielectric, or reflectance of a metal. Default 0.8. `texture` multiplies it. */
    base?: Vector;
    /** 0 for a dielectric, 1 for a metal. Default 0. */
    metallic?: number;
    /** 0, smooth, to 1. Default 0.5. */
    roughness?: number;
    /** Refractive index of a dielectric. Default 1.5. */
    index?: number;
    /** Factor of a dielectric's reflectance, 0 to 1. Default 1. */
    specular?: number;
    /** Further factor at normal incidence. Default white. */
    specularColor?: Vector;
    /** Share of the light that enters a dielectric and is transmitted, 0 to 1. Default 0. */
    transmission?: number;
    /** Whether transmitted light is not refracted. Default false. */
    thin?: boolean;
    /** Light that is absorbed inside per world unit. Default black. */
    absorption?: Vector;
    /** Share of the surface under a clear coat, 0 to 1. Default 0. */
    clearcoat?: number;
    /** Roughness of the clear coat, 0 to 1. Default 0. */
    clearcoatRoughness?: number;
    /** Factor of the normals' x and y. Default 1. */
    normalScale?: number;
    /** Its green multiplies the roughness. */
    roughnessTexture?: number;
    /** Its blue multiplies `metallic`. */
    metallicTexture?: number;
    /** Normals in tangent space, with green up. */
    normalTexture?: number;
    emissionTexture?: number;
    /** Its red multiplies `transmission`. */
    transmissionTexture?: number;
    /** Its red multiplies `clearcoat`. */
    clearcoatTexture?: number;
    /** Its green multiplies `clearcoatRoughness`. */
    clearcoatRoughnessTexture?: number;
}

/** A point light, or with a radius a spherical light, whose shadows have a penumbra. Lengths are in world units. */
export interface Light {
    position: Vector;
    /** Radiance that the light adds to a white surface that faces it; with falloff, at a distance of 1. */
    intensity: Vector;
    radius?: number;
    /** Whether brightness falls with the square of the distance. Default "none". */
    falloff?: "none" | "quadratic";
    /** Cone of a spot light: its axis, and angles in radians of full and of no brightness, 0 <= inner < outer <= pi/2. */
    cone?: { direction: Vector; inner: number; outer: number };
    /**
     * Picture that a point light projects. `texture` is an id of `addTexture`, whose linear colour multiplies the
     * intensity. `direction` leads to the picture's middle, `up` is up in it, and `fov` is the full horizontal field of
     * view in radians, 0.001 <= fov < pi.
     */
    projector?: { texture: number; direction: Vector; up: Vector; fov: number };
}

/** Triangles. Lists have one entry for each vertex, as in glTF and three.js. */
export interface Mesh {
    /** World positions, three numbers per vertex. */
    positions: Float32Array;
    /** Three vertex indices per triangle. Without indices, each three vertices make a triangle. */
    indices?: Uint32Array | Uint16Array;
    /** Unit normals, three numbers per vertex. */
    normals?: Float32Array;
    /** Texture coordinates, two numbers per vertex. (0, 0) is a texture's lower left corner, (1, 1) the upper right. */
    uvs?: Float32Array;
    /** Factors of the albedo, three numbers per vertex, linear RGB. */
    colors?: Float32Array;
    /** Id of a material. Default 0, the grey one. */
    material?: number;
    name?: string;
    /** Makes normals that are smooth across edges where triangles differ by less than this angle in degrees. */
    creaseAngle?: number;
}
