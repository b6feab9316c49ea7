// Parts that all correction passes share: choice of the view for a direction, sampling of its
// picture, the flat panel, weights in linear light, black level.
//
// The passes are specialised before they are compiled: `constants` becomes a constant of the
// program text, so that the compiler decides each `if` on its counts and switches, and no uniform
// is loaded per pixel. The file of a pass gives `Constants` (its first member is `shared_part:
// Shared`), `Source`, which is interpolated over the output, and `trace`. The file of an
// arrangement of the views' pictures gives `atlas`, `texel` and `picture_size`. Either
// `content.wgsl` or `views.wgsl` gives `locate_content` and `content_texel`. Code that a shader
// does not need costs time to compile, even where it is never run.

// A perspective view in the atlas (or the flat panel).
struct View {
    // base → (x, y, z). The view shows the directions with max(|x|, |y|) ≤ z, which are in front of
    // it.
    transform: mat3x3<f32>,
    // Atlas coordinates = scale·(x, y)/z + offset.
    scale: vec2<f32>,
    offset: vec2<f32>,
    // Index of the view in the plan, plus one.
    number: f32,
    // The view takes all directions that no earlier view takes.
    last_resort: u32,
}

// A picture that the program has projected itself.
struct Content {
    // 0: none. 1: a fisheye. 2: unrolled with latitude upwards. 3: unrolled with heights. 4: the
    // faces of a cube. 5: a plane.
    kind: u32,
    // Curve of a fisheye. 0: the radius divided by the angle is a polynomial of the angle's square.
    // Otherwise the radius is a factor times 1: sin(angle/2), 2: tan(angle/2), 3: sin(angle).
    curve: u32,
    // The polynomial, constant first; otherwise the factor.
    radius: vec4<f32>,
    // Position in the picture, −1…1, = (longitude, latitude or height − middle)·scale; of a plane,
    // tangents·scale.
    middle: f32,
    scale: vec2<f32>,
    // The left and right sides adjoin.
    wraps: u32,
    // Atlas coordinates = offset + half_size·position.
    offset: vec2<f32>,
    half_size: vec2<f32>,
    // One texel in atlas coordinates.
    step: vec2<f32>,
}

struct Shared {
    // In order of precedence. With no views, base already is (scale·x, scale·y, z) of the only one.
    views: array<View, 8>,
    view_count: u32,
    // The only view is the output's own picture: atlas coordinates = own_scale·source +
    // sole_offset.
    one_to_one: u32,
    own_scale: vec2<f32>,
    // Takes the place of the views.
    content: Content,
    // `offset` and `number` of the only view where `view_count` is 0.
    sole_offset: vec2<f32>,
    sole_number: f32,
    // Some pixels show nothing.
    edge: u32,
    panel: View,
    with_panel: u32,
    with_mask: u32,
    // Some weight differs from 1.
    weighted: u32,
    // Angle (0 polar, 1 azimuth), its value where the weight is 0, 1/(full − zero), shape.
    ramps: array<vec4<f32>, 8>,
    ramp_count: u32,
    // The display's response: w^(1/γ) = t·(1 + (t − 1)·h(t)), t = ⁴√w; h with the constant first.
    encoding: array<vec4<f32>, 2>,
    // A picture of the raised black replaces the level.
    with_black: u32,
    // Black level, encoded.
    black: vec3<f32>,
    // Weights multiply light, not codes.
    in_light: u32,
    // The display's response. 0: powers. 1: sRGB. 2: measured.
    response: u32,
    gamma: vec3<f32>,
    // Measured response: the values at which the fourth root of the light is 1/32, 2/32 … 1, for
    // red, green and blue.
    codes: array<vec4<f32>, 32>,
    // Greatest light of all projectors' blacks at any point; 0: black is not evened out.
    lift: f32,
    // A step of the display's codes if it is dithered, otherwise 0.
    dither: f32,
    // The filter is Catmull and Rom's cubic one, not the bilinear one.
    cubic: u32,
    // Four places of a pixel are sampled instead of its middle.
    four_places: u32,
}

// Result of tracing a pixel.
struct Ray {
    // Homogeneous direction, of positive scale, that the views' transforms take.
    base: vec3<f32>,
    // The pixel shows a part of the screen.
    on_screen: bool,
    // Direction from the dome's centre to the point of the screen, pole +y, front −z, positive
    // scale.
    dome: vec3<f32>,
    // Weight from the overlap with other outputs, linear light.
    weight: f32,
    // Light of all outputs' blacks at the point.
    dark: f32,
}

@group(0) @binding(0) var<uniform> constants: Constants;
@group(0) @binding(2) var atlas_sampler: sampler;
@group(0) @binding(3) var mask: texture_2d<f32>;
@group(0) @binding(4) var mask_sampler: sampler;
// Displayed values. The binding stands after the images of views.
@group(0) @binding(13) var black_picture: texture_2d<f32>;

struct Corner {
    @builtin(position) position: vec4<f32>,
    // The source's own coordinates.
    @location(0) source: Source,
    // Position in the output, 0…1, from the top left.
    @location(1) place: vec2<f32>,
}

fn corner_at(position: vec2<f32>, clip: vec2<f32>, source: Source) -> Corner {
    return Corner(vec4<f32>(position, 0.0, 1.0), source, vec2<f32>(0.5 + 0.5 * clip.x, 0.5 - 0.5 * clip.y));
}

@vertex
fn rectangle(@location(0) clip: vec2<f32>, @location(1) source: Source) -> Corner {
    return corner_at(clip, clip, source);
}

// The same where clip coordinates have y down, as in Vulkan.
@vertex
fn rectangle_down(@location(0) clip: vec2<f32>, @location(1) source: Source) -> Corner {
    return corner_at(vec2<f32>(clip.x, -clip.y), clip, source);
}

// Place in a view that shows a direction. The offset is added after the division: before it, it
// would be rounded several times.
struct Place {
    // (scale·x, scale·y, z, number of the view or 0)
    scaled: vec4<f32>,
    offset: vec2<f32>,
}

fn place_in(view: View, s: vec3<f32>) -> Place {
    return Place(vec4<f32>(s.xy * view.scale, s.z, view.number), view.offset);
}

fn coordinates(place: Place) -> vec2<f32> {
    return place.scaled.xy / place.scaled.z + place.offset;
}

fn covers(s: vec3<f32>) -> bool {
    return max(abs(s.x), abs(s.y)) <= s.z;
}

fn prefer(view: View, base: vec3<f32>, found: Place) -> Place {
    let s = view.transform * base;
    let here = place_in(view, s);
    let answers = covers(s) | (view.last_resort != 0u);
    return Place(select(found.scaled, here.scaled, answers), select(found.offset, here.offset, answers));
}

// Returns (atlas x, atlas y, number of the view, or of content's part, or 0).
fn locate(ray: Ray, source: Source) -> vec3<f32> {
    if constants.shared_part.content.kind != 0u {
        return locate_content(ray);
    }
    // Written out instead of a loop: constant indices let the compiler see the coefficients.
    let nowhere = vec4<f32>(0.0, 0.0, 1.0, 0.0);
    var found = Place(nowhere, vec2<f32>(0.0));
    if constants.shared_part.view_count == 0u {
        found = Place(vec4<f32>(ray.base, constants.shared_part.sole_number), constants.shared_part.sole_offset);
    }
    if constants.shared_part.one_to_one != 0u {
        found.scaled = vec4<f32>(constants.shared_part.own_scale * source.xy, 1.0, constants.shared_part.sole_number);
    }
    if constants.shared_part.view_count > 7u {
        found = prefer(constants.shared_part.views[7], ray.base, found);
    }
    if constants.shared_part.view_count > 6u {
        found = prefer(constants.shared_part.views[6], ray.base, found);
    }
    if constants.shared_part.view_count > 5u {
        found = prefer(constants.shared_part.views[5], ray.base, found);
    }
    if constants.shared_part.view_count > 4u {
        found = prefer(constants.shared_part.views[4], ray.base, found);
    }
    if constants.shared_part.view_count > 3u {
        found = prefer(constants.shared_part.views[3], ray.base, found);
    }
    if constants.shared_part.view_count > 2u {
        found = prefer(constants.shared_part.views[2], ray.base, found);
    }
    if constants.shared_part.view_count > 1u {
        found = prefer(constants.shared_part.views[1], ray.base, found);
    }
    if constants.shared_part.view_count > 0u {
        found = prefer(constants.shared_part.views[0], ray.base, found);
    }
    if constants.shared_part.edge != 0u {
        found.scaled = select(nowhere, found.scaled, ray.on_screen);
    }
    return vec3<f32>(coordinates(found), found.scaled.w);
}

// Eight coefficients, lowest power first.
fn polynomial(low: vec4<f32>, high: vec4<f32>, s: f32) -> f32 {
    // Paired instead of nested: processors wait for the longest chain.
    let s2 = s * s;
    return ((low.x + low.y * s) + s2 * (low.z + low.w * s))
        + (s2 * s2) * ((high.x + high.y * s) + s2 * (high.z + high.w * s));
}

// Direction of a point of a fisheye's disc, s = |disc|², any length: two polynomials and a root.
fn radial(
    disc: vec2<f32>,
    s: f32,
    sine: array<vec4<f32>, 2>,
    cosine: array<vec4<f32>, 2>,
    root: vec3<f32>,
) -> vec3<f32> {
    var across = polynomial(sine[0], sine[1], s);
    var along = polynomial(cosine[0], cosine[1], s);
    if root.x != 0.0 {
        let rest = sqrt(max(1.0 - root.x * s, 0.0));
        across += root.y * rest;
        along += root.z * rest;
    }
    return vec3<f32>(disc * across, -along);
}

// t²(3 − 2t)
fn smooth_step(t: f32) -> f32 {
    return (t * t) * (3.0 - 2.0 * t);
}

// A ramp at t, 0…1. Shape 0: smoothstep. Negative: ½ − ½·cos πt = sin² ½πt, by a polynomial.
// Otherwise the power of two halves, the second turned about the middle. The first two have a
// relative error of 4e-7, near 0 too: where all raw weights of a point are small, the blend weights
// are quotients of such values.
fn ramp_at(t: f32, shape: f32) -> f32 {
    if shape == 0.0 {
        return smooth_step(t);
    }
    if shape < 0.0 {
        let s = t * t;
        let sine = t * (1.57079632 + s * (-0.64596376 + s * (0.07968992 + s * (-0.00467414 + s * 0.00015167))));
        return min(sine * sine, 1.0);
    }
    let half_part = 0.5 * pow(2.0 * min(t, 1.0 - t), shape);
    return select(1.0 - half_part, half_part, t < 0.5);
}

// The angle of (x, y) from the x axis, −π…π; 0 at the origin. The error is 1.7e-8 of the angle plus
// rounding. Drivers' own atan may be wrong by 4096 units in the last place.
fn angle_of(y: f32, x: f32) -> f32 {
    let ax = abs(x);
    let ay = abs(y);
    let t = min(ax, ay) / max(max(ax, ay), 1e-30);
    let s = t * t;
    let p = -0.33333153 + s * (0.19993772 + s * (-0.14211052 + s * (0.10665993
        + s * (-0.07552189 + s * (0.04321156 + s * (-0.01636774 + s * 0.00292065))))));
    var a = t + t * s * p;
    a = select(a, 1.57079632679 - a, ay > ax);
    a = select(a, 3.14159265359 - a, x < 0.0);
    return select(a, -a, y < 0.0);
}

fn ramp_weight(ramp: vec4<f32>, polar: f32, azimuth: f32) -> f32 {
    return ramp_at(clamp((select(polar, azimuth, ramp.x > 0.5) - ramp.y) * ramp.z, 0.0, 1.0), ramp.w);
}

fn ramps_weight(dome: vec3<f32>) -> f32 {
    let polar = angle_of(sqrt(dome.x * dome.x + dome.z * dome.z), dome.y);
    let azimuth = angle_of(dome.x, -dome.z);
    var weight = ramp_weight(constants.shared_part.ramps[0], polar, azimuth);
    if constants.shared_part.ramp_count > 1u {
        weight *= ramp_weight(constants.shared_part.ramps[1], polar, azimuth);
    }
    if constants.shared_part.ramp_count > 2u {
        weight *= ramp_weight(constants.shared_part.ramps[2], polar, azimuth);
    }
    if constants.shared_part.ramp_count > 3u {
        weight *= ramp_weight(constants.shared_part.ramps[3], polar, azimuth);
    }
    if constants.shared_part.ramp_count > 4u {
        weight *= ramp_weight(constants.shared_part.ramps[4], polar, azimuth);
    }
    if constants.shared_part.ramp_count > 5u {
        weight *= ramp_weight(constants.shared_part.ramps[5], polar, azimuth);
    }
    if constants.shared_part.ramp_count > 6u {
        weight *= ramp_weight(constants.shared_part.ramps[6], polar, azimuth);
    }
    if constants.shared_part.ramp_count > 7u {
        weight *= ramp_weight(constants.shared_part.ramps[7], polar, azimuth);
    }
    return weight;
}

// Product of all weights of a pixel, linear light.
fn weight_of(ray: Ray, place: vec2<f32>) -> f32 {
    var weight = ray.weight;
    if constants.shared_part.ramp_count > 0u {
        weight *= ramps_weight(ray.dome);
    }
    if constants.shared_part.with_mask != 0u {
        weight *= textureSampleLevel(mask, mask_sampler, place, 0.0).x;
    }
    return weight;
}

// Factor on encoded values that multiplies light by `weight`, 0…1; exact at both ends.
fn encode(weight: f32) -> f32 {
    let t = sqrt(sqrt(weight));
    let h = polynomial(constants.shared_part.encoding[0], constants.shared_part.encoding[1], t);
    return t * (1.0 + (t - 1.0) * h);
}

// Position of `code` between two points of a measured response, 0…1.
fn between_codes(code: vec3<f32>, before: vec4<f32>, after: vec4<f32>) -> vec3<f32> {
    return clamp((code - before.xyz) / (after.xyz - before.xyz), vec3<f32>(0.0), vec3<f32>(1.0));
}

// Fourth root of the light of a measured response: straight lines between its points.
fn measured_root(code: vec3<f32>) -> vec3<f32> {
    var sum = between_codes(code, vec4<f32>(0.0), constants.shared_part.codes[0]);
    sum += between_codes(code, constants.shared_part.codes[0], constants.shared_part.codes[1]);
    sum += between_codes(code, constants.shared_part.codes[1], constants.shared_part.codes[2]);
    sum += between_codes(code, constants.shared_part.codes[2], constants.shared_part.codes[3]);
    sum += between_codes(code, constants.shared_part.codes[3], constants.shared_part.codes[4]);
    sum += between_codes(code, constants.shared_part.codes[4], constants.shared_part.codes[5]);
    sum += between_codes(code, constants.shared_part.codes[5], constants.shared_part.codes[6]);
    sum += between_codes(code, constants.shared_part.codes[6], constants.shared_part.codes[7]);
    sum += between_codes(code, constants.shared_part.codes[7], constants.shared_part.codes[8]);
    sum += between_codes(code, constants.shared_part.codes[8], constants.shared_part.codes[9]);
    sum += between_codes(code, constants.shared_part.codes[9], constants.shared_part.codes[10]);
    sum += between_codes(code, constants.shared_part.codes[10], constants.shared_part.codes[11]);
    sum += between_codes(code, constants.shared_part.codes[11], constants.shared_part.codes[12]);
    sum += between_codes(code, constants.shared_part.codes[12], constants.shared_part.codes[13]);
    sum += between_codes(code, constants.shared_part.codes[13], constants.shared_part.codes[14]);
    sum += between_codes(code, constants.shared_part.codes[14], constants.shared_part.codes[15]);
    sum += between_codes(code, constants.shared_part.codes[15], constants.shared_part.codes[16]);
    sum += between_codes(code, constants.shared_part.codes[16], constants.shared_part.codes[17]);
    sum += between_codes(code, constants.shared_part.codes[17], constants.shared_part.codes[18]);
    sum += between_codes(code, constants.shared_part.codes[18], constants.shared_part.codes[19]);
    sum += between_codes(code, constants.shared_part.codes[19], constants.shared_part.codes[20]);
    sum += between_codes(code, constants.shared_part.codes[20], constants.shared_part.codes[21]);
    sum += between_codes(code, constants.shared_part.codes[21], constants.shared_part.codes[22]);
    sum += between_codes(code, constants.shared_part.codes[22], constants.shared_part.codes[23]);
    sum += between_codes(code, constants.shared_part.codes[23], constants.shared_part.codes[24]);
    sum += between_codes(code, constants.shared_part.codes[24], constants.shared_part.codes[25]);
    sum += between_codes(code, constants.shared_part.codes[25], constants.shared_part.codes[26]);
    sum += between_codes(code, constants.shared_part.codes[26], constants.shared_part.codes[27]);
    sum += between_codes(code, constants.shared_part.codes[27], constants.shared_part.codes[28]);
    sum += between_codes(code, constants.shared_part.codes[28], constants.shared_part.codes[29]);
    sum += between_codes(code, constants.shared_part.codes[29], constants.shared_part.codes[30]);
    sum += between_codes(code, constants.shared_part.codes[30], constants.shared_part.codes[31]);
    return sum * 0.03125;
}

// One point's part of the code; `place` is 32 times the fourth root of the light.
fn part_of_code(place: vec3<f32>, step: f32, before: vec4<f32>, after: vec4<f32>) -> vec3<f32> {
    return (after.xyz - before.xyz) * clamp(place - step, vec3<f32>(0.0), vec3<f32>(1.0));
}

// Inverse of `measured_root`.
fn measured_code(root: vec3<f32>) -> vec3<f32> {
    let place = 32.0 * root;
    var code = part_of_code(place, 0.0, vec4<f32>(0.0), constants.shared_part.codes[0]);
    code += part_of_code(place, 1.0, constants.shared_part.codes[0], constants.shared_part.codes[1]);
    code += part_of_code(place, 2.0, constants.shared_part.codes[1], constants.shared_part.codes[2]);
    code += part_of_code(place, 3.0, constants.shared_part.codes[2], constants.shared_part.codes[3]);
    code += part_of_code(place, 4.0, constants.shared_part.codes[3], constants.shared_part.codes[4]);
    code += part_of_code(place, 5.0, constants.shared_part.codes[4], constants.shared_part.codes[5]);
    code += part_of_code(place, 6.0, constants.shared_part.codes[5], constants.shared_part.codes[6]);
    code += part_of_code(place, 7.0, constants.shared_part.codes[6], constants.shared_part.codes[7]);
    code += part_of_code(place, 8.0, constants.shared_part.codes[7], constants.shared_part.codes[8]);
    code += part_of_code(place, 9.0, constants.shared_part.codes[8], constants.shared_part.codes[9]);
    code += part_of_code(place, 10.0, constants.shared_part.codes[9], constants.shared_part.codes[10]);
    code += part_of_code(place, 11.0, constants.shared_part.codes[10], constants.shared_part.codes[11]);
    code += part_of_code(place, 12.0, constants.shared_part.codes[11], constants.shared_part.codes[12]);
    code += part_of_code(place, 13.0, constants.shared_part.codes[12], constants.shared_part.codes[13]);
    code += part_of_code(place, 14.0, constants.shared_part.codes[13], constants.shared_part.codes[14]);
    code += part_of_code(place, 15.0, constants.shared_part.codes[14], constants.shared_part.codes[15]);
    code += part_of_code(place, 16.0, constants.shared_part.codes[15], constants.shared_part.codes[16]);
    code += part_of_code(place, 17.0, constants.shared_part.codes[16], constants.shared_part.codes[17]);
    code += part_of_code(place, 18.0, constants.shared_part.codes[17], constants.shared_part.codes[18]);
    code += part_of_code(place, 19.0, constants.shared_part.codes[18], constants.shared_part.codes[19]);
    code += part_of_code(place, 20.0, constants.shared_part.codes[19], constants.shared_part.codes[20]);
    code += part_of_code(place, 21.0, constants.shared_part.codes[20], constants.shared_part.codes[21]);
    code += part_of_code(place, 22.0, constants.shared_part.codes[21], constants.shared_part.codes[22]);
    code += part_of_code(place, 23.0, constants.shared_part.codes[22], constants.shared_part.codes[23]);
    code += part_of_code(place, 24.0, constants.shared_part.codes[23], constants.shared_part.codes[24]);
    code += part_of_code(place, 25.0, constants.shared_part.codes[24], constants.shared_part.codes[25]);
    code += part_of_code(place, 26.0, constants.shared_part.codes[25], constants.shared_part.codes[26]);
    code += part_of_code(place, 27.0, constants.shared_part.codes[26], constants.shared_part.codes[27]);
    code += part_of_code(place, 28.0, constants.shared_part.codes[27], constants.shared_part.codes[28]);
    code += part_of_code(place, 29.0, constants.shared_part.codes[28], constants.shared_part.codes[29]);
    code += part_of_code(place, 30.0, constants.shared_part.codes[29], constants.shared_part.codes[30]);
    code += part_of_code(place, 31.0, constants.shared_part.codes[30], constants.shared_part.codes[31]);
    return code;
}

// Light that the display makes of codes.
fn to_light(code: vec3<f32>) -> vec3<f32> {
    if constants.shared_part.response == 2u {
        let root = measured_root(code);
        return (root * root) * (root * root);
    }
    if constants.shared_part.response == 1u {
        let curve = pow((code + 0.055) / 1.055, vec3<f32>(2.4));
        return select(curve, code / 12.92, code <= vec3<f32>(0.04045));
    }
    return pow(code, constants.shared_part.gamma);
}

// Codes of which the display makes this light.
fn to_code(light: vec3<f32>) -> vec3<f32> {
    if constants.shared_part.response == 2u {
        return measured_code(sqrt(sqrt(light)));
    }
    if constants.shared_part.response == 1u {
        let curve = 1.055 * pow(light, vec3<f32>(1.0 / 2.4)) - 0.055;
        return select(curve, light * 12.92, light <= vec3<f32>(0.0031308));
    }
    return pow(light, 1.0 / constants.shared_part.gamma);
}

// Light of the picture, plus the light that this point's black lacks to the brightest, weighted.
fn weighted_light(code: vec3<f32>, weight: f32, dark: f32) -> vec3<f32> {
    let share = (1.0 - constants.shared_part.lift) * to_light(code) + max(constants.shared_part.lift - dark, 0.0);
    return to_code(weight * share);
}

// Between −½ and ½, evenly distributed, different from pixel to pixel and the same in each frame:
// interleaved gradient noise (Jimenez 2014).
fn noise_at(position: vec2<f32>) -> f32 {
    return fract(52.9829189 * fract(dot(position, vec2<f32>(0.06711056, 0.00583715)))) - 0.5;
}

// The panel's premultiplied colour over the scene.
fn with_panel(ray: Ray, scene: vec3<f32>) -> vec3<f32> {
    let s = constants.shared_part.panel.transform * ray.base;
    let inside = covers(s);
    let place = place_in(constants.shared_part.panel, s);
    let at = select(vec2<f32>(0.0), coordinates(place), inside);
    let flat_part = texel(vec3<f32>(at, constants.shared_part.panel.number));
    return select(scene, flat_part.rgb + (1.0 - flat_part.a) * scene, inside);
}

// A view's picture by Catmull and Rom's cubic kernel: its 16 texels by nine bilinear fetches, since
// the two in the middle of each direction have weights of the same sign.
fn cubic(at: vec3<f32>) -> vec3<f32> {
    let size = picture_size(at.z);
    let place = at.xy * size;
    let first = floor(place - 0.5) + 0.5;
    let f = place - first;
    let w0 = f * (-0.5 + f * (1.0 - 0.5 * f));
    let w1 = 1.0 + f * f * (-2.5 + 1.5 * f);
    let w2 = f * (0.5 + f * (2.0 - 1.5 * f));
    let w3 = f * f * (-0.5 + 0.5 * f);
    let w12 = w1 + w2;
    let before = (first - 1.0) / size;
    let middle = (first + w2 / w12) / size;
    let after = (first + 2.0) / size;
    let columns = vec3<f32>(w0.x, w12.x, w3.x);
    let x = vec3<f32>(before.x, middle.x, after.x);
    let sum = cubic_row(x, before.y, at.z, columns) * w0.y + cubic_row(x, middle.y, at.z, columns) * w12.y
        + cubic_row(x, after.y, at.z, columns) * w3.y;
    return clamp(sum, vec3<f32>(0.0), vec3<f32>(1.0));
}

fn cubic_row(x: vec3<f32>, y: f32, number: f32, weights: vec3<f32>) -> vec3<f32> {
    return nearby(vec3<f32>(x.x, y, number)) * weights.x + nearby(vec3<f32>(x.y, y, number)) * weights.y
        + nearby(vec3<f32>(x.z, y, number)) * weights.z;
}

// The mean of the texels around a place, weighted by nearness.
fn nearby(at: vec3<f32>) -> vec3<f32> {
    if constants.shared_part.content.kind != 0u {
        return content_texel(at).rgb;
    }
    return texel(at).rgb;
}

fn sample(at: vec3<f32>) -> vec3<f32> {
    if constants.shared_part.cubic != 0u {
        return cubic(at);
    }
    return nearby(at);
}

// A place beside the pixel's centre, which is taken where that place shows nothing.
fn sample_beside(source: Source, centre: vec3<f32>) -> vec3<f32> {
    let at = locate(trace(source), source);
    return sample(select(centre, at, at.z > 0.0));
}

// The mean of four places on a rotated grid. The source's coordinates are linear in the pixel, so
// that their derivatives are right where those of the atlas' coordinates jump from view to view.
fn sample_four(source: Source, centre: vec3<f32>) -> vec3<f32> {
    let across = dpdx(source);
    let up = dpdy(source);
    return 0.25 * ((sample_beside(source + 0.125 * across + 0.375 * up, centre)
        + sample_beside(source - 0.375 * across + 0.125 * up, centre))
        + (sample_beside(source - 0.125 * across - 0.375 * up, centre)
        + sample_beside(source + 0.375 * across - 0.125 * up, centre)));
}

@fragment
fn present(corner: Corner) -> @location(0) vec4<f32> {
    let ray = trace(corner.source);
    let at = locate(ray, corner.source);
    var color = vec3<f32>(0.0);
    if constants.shared_part.four_places != 0u {
        color = sample_four(corner.source, at);
    } else {
        color = sample(at);
    }
    if constants.shared_part.with_panel != 0u {
        color = with_panel(ray, color);
    }
    if constants.shared_part.weighted != 0u {
        let weight = weight_of(ray, corner.place);
        if constants.shared_part.in_light != 0u {
            color = weighted_light(color, weight, ray.dark);
        } else {
            color *= encode(weight);
        }
    }
    if constants.shared_part.with_black != 0u {
        let black = textureSampleLevel(black_picture, mask_sampler, corner.place, 0.0).xyz;
        color = black + (1.0 - black) * color;
    } else if constants.shared_part.black.x > 0.0 {
        color = constants.shared_part.black + (1.0 - constants.shared_part.black) * color;
    }
    if constants.shared_part.dither > 0.0 {
        color += constants.shared_part.dither * noise_at(corner.position.xy);
    }
    if constants.shared_part.edge != 0u {
        color = select(vec3<f32>(0.0), color, at.z > 0.0);
    }
    return vec4<f32>(color, 1.0);
}

// What `present` computes before it samples: atlas x, atlas y, number of the view (0: none),
// weight.
@fragment
fn map(corner: Corner) -> @location(0) vec4<f32> {
    let ray = trace(corner.source);
    return vec4<f32>(locate(ray, corner.source), weight_of(ray, corner.place));
}
