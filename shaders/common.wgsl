// What every correction pass shares: which view answers for a direction, the one bilinear fetch
// from its picture, the flat panel, weights in linear light, black level.
//
// The passes are specialised before they are compiled: `constants` becomes a constant of the
// program text, so that each `if` on its counts and switches is decided by the compiler and no
// uniform is loaded per pixel. A file of a pass gives `Constants` (its first member is
// `shared_part: Shared`) and `trace`; a file of an arrangement of the views' pictures gives `atlas` and `texel`.

// A perspective view in the atlas (or the flat panel).
struct View {
    // base → (x, y, z); the view answers for max(|x|, |y|) ≤ z, which also means: in front of it.
    transform: mat3x3<f32>,
    // Atlas coordinates = scale·(x, y)/z + offset.
    scale: vec2<f32>,
    offset: vec2<f32>,
    // Its index in the plan plus one.
    number: f32,
    // Answers for everything that no earlier view answers for.
    last_resort: u32,
}

struct Shared {
    // In order of precedence. None: base already is (atlas x, atlas y, 1) times a positive factor.
    views: array<View, 8>,
    view_count: u32,
    // `number` of the view where `view_count` is 0.
    sole_number: f32,
    // Some pixels show nothing.
    edge: u32,
    panel: View,
    with_panel: u32,
    with_mask: u32,
    // Any weight differs from 1.
    weighted: u32,
    // Angle (0 polar, 1 azimuth), its value where the weight is 0, 1/(full − zero).
    ramps: array<vec4<f32>, 8>,
    ramp_count: u32,
    // The display's response: w^(1/γ) = t·(1 + (t − 1)·h(t)), t = ⁴√w; h with the constant first.
    encoding: array<vec4<f32>, 2>,
    // Black level, encoded.
    black: f32,
}

// What a pass knows of a pixel.
struct Ray {
    // Homogeneous direction that the views' transforms take, positive scale.
    base: vec3<f32>,
    // The pixel shows a part of the screen.
    on_screen: bool,
    // Direction of the screen's point from the dome's centre, pole +y, front −z, positive scale.
    dome: vec3<f32>,
    // Weight from the overlap with other outputs, linear light.
    weight: f32,
}

@group(0) @binding(0) var<uniform> constants: Constants;
@group(0) @binding(2) var atlas_sampler: sampler;
@group(0) @binding(3) var mask: texture_2d<f32>;
@group(0) @binding(4) var mask_sampler: sampler;

struct Corner {
    @builtin(position) position: vec4<f32>,
    // The source's own coordinates.
    @location(0) source: vec2<f32>,
    // Position in the output, 0…1, from the top left.
    @location(1) place: vec2<f32>,
}

fn corner_at(position: vec2<f32>, clip: vec2<f32>, source: vec2<f32>) -> Corner {
    return Corner(vec4<f32>(position, 0.0, 1.0), source, vec2<f32>(0.5 + 0.5 * clip.x, 0.5 - 0.5 * clip.y));
}

@vertex
fn rectangle(@location(0) clip: vec2<f32>, @location(1) source: vec2<f32>) -> Corner {
    return corner_at(clip, clip, source);
}

// The same where clip coordinates have y down, as in Vulkan.
@vertex
fn rectangle_down(@location(0) clip: vec2<f32>, @location(1) source: vec2<f32>) -> Corner {
    return corner_at(vec2<f32>(clip.x, -clip.y), clip, source);
}

// Atlas coordinates times z, z, number.
fn place_in(view: View, s: vec3<f32>) -> vec4<f32> {
    return vec4<f32>(s.xy * view.scale + view.offset * s.z, s.z, view.number);
}

fn covers(s: vec3<f32>) -> bool {
    return max(abs(s.x), abs(s.y)) <= s.z;
}

fn prefer(view: View, base: vec3<f32>, found: vec4<f32>) -> vec4<f32> {
    let s = view.transform * base;
    return select(found, place_in(view, s), covers(s) | (view.last_resort != 0u));
}

// (atlas x, atlas y, number of the view or 0)
fn locate(ray: Ray) -> vec3<f32> {
    // Written out, not looped: constant indices let the compiler see the coefficients.
    var found = vec4<f32>(0.0, 0.0, 1.0, 0.0);
    if constants.shared_part.view_count == 0u {
        found = vec4<f32>(ray.base, constants.shared_part.sole_number);
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
        found = select(vec4<f32>(0.0, 0.0, 1.0, 0.0), found, ray.on_screen);
    }
    return vec3<f32>(found.xy / found.z, found.w);
}

// Eight coefficients, lowest power first.
fn polynomial(low: vec4<f32>, high: vec4<f32>, s: f32) -> f32 {
    // Paired off, not nested: processors wait for the longest chain.
    let s2 = s * s;
    return ((low.x + low.y * s) + s2 * (low.z + low.w * s))
        + (s2 * s2) * ((high.x + high.y * s) + s2 * (high.z + high.w * s));
}

// t²(3 − 2t)
fn smooth_step(t: f32) -> f32 {
    return (t * t) * (3.0 - 2.0 * t);
}

// The same, clamped outside 0…1.
fn smooth_ramp(t: f32) -> f32 {
    return smooth_step(clamp(t, 0.0, 1.0));
}

// The angle of (x, y) from the x axis, −π…π; 0 at the origin. Error 1.7e-8 of the angle plus
// rounding: drivers' own atan is allowed 4096 units in the last place.
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
    return smooth_ramp((select(polar, azimuth, ramp.x > 0.5) - ramp.y) * ramp.z);
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

// All weights of a pixel, linear light.
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

// The factor on encoded values that multiplies light by `weight`, 0…1; exact at both ends.
fn encode(weight: f32) -> f32 {
    let t = sqrt(sqrt(weight));
    let h = polynomial(constants.shared_part.encoding[0], constants.shared_part.encoding[1], t);
    return t * (1.0 + (t - 1.0) * h);
}

// The panel's premultiplied colour over the scene.
fn with_panel(ray: Ray, scene: vec3<f32>) -> vec3<f32> {
    let s = constants.shared_part.panel.transform * ray.base;
    let inside = covers(s);
    let at = select(vec3<f32>(0.0, 0.0, 1.0), place_in(constants.shared_part.panel, s).xyz, inside);
    let flat_part = texel(vec3<f32>(at.xy / at.z, constants.shared_part.panel.number));
    return select(scene, flat_part.rgb + (1.0 - flat_part.a) * scene, inside);
}

@fragment
fn present(corner: Corner) -> @location(0) vec4<f32> {
    let ray = trace(corner.source);
    let at = locate(ray);
    var color = texel(at).rgb;
    if constants.shared_part.with_panel != 0u {
        color = with_panel(ray, color);
    }
    if constants.shared_part.weighted != 0u {
        let weight = weight_of(ray, corner.place);
        color *= encode(weight);
    }
    if constants.shared_part.black > 0.0 {
        color = constants.shared_part.black + (1.0 - constants.shared_part.black) * color;
    }
    if constants.shared_part.edge != 0u {
        color = select(vec3<f32>(0.0), color, at.z > 0.0);
    }
    return vec4<f32>(color, 1.0);
}

// What `present` computes before it samples: atlas x, atlas y, number of the view (0: none), weight.
@fragment
fn map(corner: Corner) -> @location(0) vec4<f32> {
    let ray = trace(corner.source);
    return vec4<f32>(locate(ray), weight_of(ray, corner.place));
}
