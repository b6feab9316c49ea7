// A pinhole projector that lights a sphere, another quadric or a plane: pixel → direction from the
// viewer, in closed form: a quadratic form, plus a linear one times the root of the discriminant.

// Normalised coordinates of the output.
alias Source = vec2<f32>;

struct Form {
    q_xx: vec3<f32>,
    q_yy: vec3<f32>,
    q_xy: vec3<f32>,
    q_x: vec3<f32>,
    q_y: vec3<f32>,
    q_one: vec3<f32>,
    l_x: vec3<f32>,
    l_y: vec3<f32>,
    l_one: vec3<f32>,
    // With evaluations 2 and 3 there is no quadratic part: the form is offset·reach + linear.
    offset: vec3<f32>,
}

struct Neighbour {
    // Pixel of this output → picture coordinates of the neighbour, homogeneous.
    picture: Form,
    border: vec4<f32>,
}

struct Constants {
    shared_part: Shared,
    direction: Form,
    dome: Form,
    // Discriminant over x², y², xy, x; y, 1.
    discriminant: array<vec4<f32>, 2>,
    // Evaluation of forms. 0: as they are. 1: for a plane they are linear. Otherwise the projector
    // stands inside. With a ray o + t·d, a = d·d and b = o·d, all forms are then offset·reach +
    // linear, times a positive factor. 2: reach is the root of the discriminant. 3: the projector
    // stands too near to the surface for that, and reach is 1/t.
    evaluation: u32,
    // a over x², y², xy, x; y, 1. b over x, y, 1.
    squared: array<vec4<f32>, 2>,
    along: vec3<f32>,
    // 0: the whole surface is screen. Otherwise the screen is where all of `limits` is ≥ 0; with 2
    // also x and y of `sides`, with 3 one of them.
    edge_test: u32,
    limits: Form,
    sides: Form,
    neighbours: array<Neighbour, 12>,
    neighbour_count: u32,
    border: vec4<f32>,
}

// Sums of monomials, which all forms of a pixel share, in pairs. Horner's scheme needs as many
// operations, but each would wait for the one before it.
fn quadratic(low: vec4<f32>, high: vec4<f32>, p: vec2<f32>) -> f32 {
    return ((low.x * (p.x * p.x) + low.y * (p.y * p.y)) + (low.z * (p.x * p.y) + low.w * p.x))
        + (high.x * p.y + high.y);
}

fn evaluate(form: Form, p: vec2<f32>, reach: f32) -> vec3<f32> {
    let linear = (form.l_x * p.x + form.l_y * p.y) + form.l_one;
    if constants.evaluation == 1u {
        return linear;
    }
    if constants.evaluation >= 2u {
        return form.offset * reach + linear;
    }
    let rest = ((form.q_xx * (p.x * p.x) + form.q_yy * (p.y * p.y)) + (form.q_xy * (p.x * p.y) + form.q_x * p.x))
        + (form.q_y * p.y + form.q_one);
    return rest + linear * reach;
}

// Raw weight of a point in a picture whose ramps are at `steps` (0…1). A border is 1/(2·width of
// the ramp), the ramp's shape, the raw weight's exponent, the light of black.
fn claim(steps: vec2<f32>, border: vec4<f32>) -> f32 {
    let product = ramp_at(steps.x, border.y) * ramp_at(steps.y, border.y);
    if border.z == 1.0 {
        return product;
    }
    return pow(product, border.z);
}

// Raw weight of a pixel's point in a neighbour's picture, and the light of the neighbour's black
// there.
fn of_neighbour(neighbour: Neighbour, p: vec2<f32>, reach: f32) -> vec2<f32> {
    let s = evaluate(neighbour.picture, p, reach);
    let inside = 1.0 - abs(s.xy * (1.0 / s.z));
    let steps = clamp(inside * neighbour.border.x, vec2<f32>(0.0), vec2<f32>(1.0));
    let black = select(0.0, neighbour.border.w, min(inside.x, inside.y) >= 0.0);
    // Behind the neighbour the quotient has no meaning, and is not used.
    return select(vec2<f32>(0.0), vec2<f32>(claim(steps, neighbour.border), black), s.z > 0.0);
}

// Blend weight of this projector at a point (all blend weights of a point add up to 1), and the
// light of all blacks there.
fn share(p: vec2<f32>, reach: f32) -> vec2<f32> {
    var others = of_neighbour(constants.neighbours[0], p, reach);
    if constants.neighbour_count > 1u {
        others += of_neighbour(constants.neighbours[1], p, reach);
    }
    if constants.neighbour_count > 2u {
        others += of_neighbour(constants.neighbours[2], p, reach);
    }
    if constants.neighbour_count > 3u {
        others += of_neighbour(constants.neighbours[3], p, reach);
    }
    if constants.neighbour_count > 4u {
        others += of_neighbour(constants.neighbours[4], p, reach);
    }
    if constants.neighbour_count > 5u {
        others += of_neighbour(constants.neighbours[5], p, reach);
    }
    if constants.neighbour_count > 6u {
        others += of_neighbour(constants.neighbours[6], p, reach);
    }
    if constants.neighbour_count > 7u {
        others += of_neighbour(constants.neighbours[7], p, reach);
    }
    if constants.neighbour_count > 8u {
        others += of_neighbour(constants.neighbours[8], p, reach);
    }
    if constants.neighbour_count > 9u {
        others += of_neighbour(constants.neighbours[9], p, reach);
    }
    if constants.neighbour_count > 10u {
        others += of_neighbour(constants.neighbours[10], p, reach);
    }
    if constants.neighbour_count > 11u {
        others += of_neighbour(constants.neighbours[11], p, reach);
    }
    // This output's pixels are inside its picture: only the upper bound is needed.
    let own = claim(min((1.0 - abs(p)) * constants.border.x, vec2<f32>(1.0)), constants.border);
    // If no other projector lights the point, the weight is 1, also at the very border.
    return vec2<f32>(select(1.0, own / (own + others.x), others.x > 0.0), constants.border.w + others.y);
}

fn trace(source: Source) -> Ray {
    var reach = 1.0;
    var on_screen = true;
    if constants.evaluation != 1u {
        let discriminant = quadratic(constants.discriminant[0], constants.discriminant[1], source);
        if constants.evaluation == 0u {
            reach = sqrt(max(discriminant, 0.0));
            on_screen = discriminant >= 0.0;
        } else {
            reach = sqrt(discriminant);
        }
    }
    if constants.evaluation == 3u {
        let b = (constants.along.x * source.x + constants.along.y * source.y) + constants.along.z;
        reach = quadratic(constants.squared[0], constants.squared[1], source) / (reach - b);
    }
    if constants.edge_test != 0u {
        on_screen = on_screen & all(evaluate(constants.limits, source, reach) >= vec3<f32>(0.0));
    }
    if constants.edge_test >= 2u {
        let sides = evaluate(constants.sides, source, reach).xy >= vec2<f32>(0.0);
        on_screen = on_screen & select(all(sides), any(sides), constants.edge_test == 3u);
    }
    var own = vec2<f32>(1.0, constants.border.w);
    if constants.neighbour_count > 0u {
        own = share(source, reach);
    }
    let dome = evaluate(constants.dome, source, reach);
    return Ray(evaluate(constants.direction, source, reach), on_screen, dome, own.x, own.y);
}
