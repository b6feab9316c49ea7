// A fisheye projector, or a pinhole before a mirror, that lights a quadric from inside: pixel → ray
// → perhaps the mirror → the screen → what the viewer sees there.

// Normalised coordinates of the output.
alias Source = vec2<f32>;

struct Constants {
    shared_part: Shared,
    // The lens is a fisheye, not a pinhole.
    fisheye: u32,
    // A fisheye's disc = source·scale + offset: xy, zw.
    disc: vec4<f32>,
    // As in fisheye.wgsl.
    sine: array<vec4<f32>, 2>,
    cosine: array<vec4<f32>, 2>,
    root: vec3<f32>,
    // Direction of the fisheye, or (x, y, 1) of a pinhole → ray in the surface's axes.
    rays: mat3x3<f32>,
    with_mirror: u32,
    // The mirror's radius.
    radius: f32,
    // (x, y, 1) → the moment of the pinhole's ray around the mirror's centre, in radii.
    moment: mat3x3<f32>,
    // Position of the lens, or of the mirror's centre.
    origin: vec3<f32>,
    // Inside the quadric Σ weights·p² is less than its level. Without a mirror, `level` is the
    // difference at the lens.
    weights: vec3<f32>,
    level: f32,
    // Point of the screen → base.
    to_base: mat3x3<f32>,
    shift: vec3<f32>,
    // Point of the screen → dome axes, for ramps.
    dome: mat3x3<f32>,
    dome_shift: vec3<f32>,
    // Half-spaces normal·p + w ≥ 0. 0: the whole surface is screen. Otherwise the screen is inside
    // all `limits`; with 2 also inside both `sides`, with 3 inside one of them.
    edge_test: u32,
    limits: array<vec4<f32>, 3>,
    sides: array<vec4<f32>, 2>,
}

fn is_within(space: vec4<f32>, p: vec3<f32>) -> bool {
    return dot(space.xyz, p) + space.w >= 0.0;
}

fn trace(source: Source) -> Ray {
    var on_screen = true;
    var lens = vec3<f32>(source, 1.0);
    if constants.fisheye != 0u {
        let disc = source * constants.disc.xy + constants.disc.zw;
        let s = dot(disc, disc);
        lens = radial(disc, s, constants.sine, constants.cosine, constants.root);
        on_screen = s <= 1.0;
    }
    var ray = constants.rays * lens;
    var start = constants.origin;
    var depth = constants.level;
    if constants.with_mirror != 0u {
        // Uses the moment, because it and its rounding errors are smaller than the distance to the
        // mirror.
        let length = sqrt(dot(ray, ray));
        ray = ray / length;
        let foot = cross(ray, constants.moment * lens) / length;
        let discriminant = 1.0 - dot(foot, foot);
        on_screen = on_screen & (discriminant > 0.0);
        let root = sqrt(max(discriminant, 0.0));
        let normal = foot - ray * root;
        ray += normal * (2.0 * root);
        start += normal * constants.radius;
        depth -= dot(constants.weights * start, start);
    }
    let weighted = constants.weights * ray;
    let b = dot(weighted, start);
    let reach = b + sqrt(max(b * b + dot(weighted, ray) * depth, 0.0));
    on_screen = on_screen & (reach > 0.0);
    let p = start + ray * (depth / reach);
    if constants.edge_test != 0u {
        on_screen = on_screen & is_within(constants.limits[0], p) & is_within(constants.limits[1], p)
            & is_within(constants.limits[2], p);
    }
    if constants.edge_test >= 2u {
        let first = is_within(constants.sides[0], p);
        let second = is_within(constants.sides[1], p);
        on_screen = on_screen & select(first & second, first | second, constants.edge_test == 3u);
    }
    return Ray(constants.to_base * p + constants.shift, on_screen, constants.dome * p + constants.dome_shift, 1.0, 0.0);
}
