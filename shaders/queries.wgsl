// Results of queries as the program gets them: each count times its factor. They are written in the
// four forms in which a program may want them, one after another: 64 bits, 64 bits with the
// availability after a query's numbers, and both with 32 bits.

// For each query: its numbers and whether they are available, 64 bits each.
@group(0) @binding(0) var<storage, read> counted: array<u32>;
// Number of numbers of a query, number of queries; then the factors of each query's numbers, 64
// bits each, of which 32 are behind the binary point.
@group(0) @binding(1) var<storage, read> factors: array<u32>;
@group(0) @binding(2) var<storage, read_write> told: array<u32>;

// Product of two numbers: its lower and its upper half.
fn product(a: u32, b: u32) -> vec2<u32> {
    let low = (a & 0xffffu) * (b & 0xffffu);
    let left = (a >> 16u) * (b & 0xffffu);
    let right = (a & 0xffffu) * (b >> 16u);
    let middle = (low >> 16u) + (left & 0xffffu) + (right & 0xffffu);
    let high = (a >> 16u) * (b >> 16u) + (left >> 16u) + (right >> 16u) + (middle >> 16u);
    return vec2<u32>((low & 0xffffu) | (middle << 16u), high);
}

fn sum(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    let low = a.x + b.x;
    return vec2<u32>(low, a.y + b.y + select(0u, 1u, low < a.x));
}

// A count times a factor, rounded; at least 1 if the count is at least 1.
fn scaled(count: vec2<u32>, factor: vec2<u32>) -> vec2<u32> {
    let rounded = sum(product(count.x, factor.x), vec2<u32>(0x80000000u, 0u)).y;
    var result = sum(vec2<u32>(rounded, 0u), product(count.x, factor.y));
    result = sum(result, product(count.y, factor.x));
    result.y += count.y * factor.y;
    if all(result == vec2<u32>(0u)) && any(count != vec2<u32>(0u)) {
        result.x = 1u;
    }
    return result;
}

@compute @workgroup_size(64)
fn tell(@builtin(global_invocation_id) at: vec3<u32>) {
    let numbers = factors[0];
    let queries = factors[1];
    let query = at.x;
    if query >= queries {
        return;
    }
    let both = numbers + 1u;
    let wide = 2u * numbers * queries;
    let narrow = wide + 2u * both * queries;
    let narrow_both = narrow + numbers * queries;
    for (var i = 0u; i < both; i++) {
        let start = 2u * (query * both + i);
        var value = vec2<u32>(counted[start], counted[start + 1u]);
        if i < numbers {
            let factor = 2u + 2u * (query * numbers + i);
            value = scaled(value, vec2<u32>(factors[factor], factors[factor + 1u]));
        }
        let clamped = select(value.x, 0xffffffffu, value.y != 0u);
        if i < numbers {
            told[2u * (query * numbers + i)] = value.x;
            told[2u * (query * numbers + i) + 1u] = value.y;
            told[narrow + query * numbers + i] = clamped;
        }
        told[wide + start] = value.x;
        told[wide + start + 1u] = value.y;
        told[narrow_both + query * both + i] = clamped;
    }
}
