// The watertight triangle test (Woop, Benthin and Wald, JCGT 2013), twin of `Shear` in sheer_accel.
//
// A compiler may fuse a product with a subtraction, which WGSL cannot forbid. Then the sign of a difference
// of two nearly equal products may be wrong, and a ray may slip between two triangles or hit both. So the
// sign of a difference that is small beside its products is taken from the products' exact integers, whatever
// the compiler does. Without fusion (Mesa's llvmpipe) all numbers are the CPU's bits, but for hits that need
// `precise_areas`.
#import shared/hit
#import shared/scene

// The ray as the test needs it; the same for all triangles.
struct WatertightRay {
    // Original axes that become x, y and z; z is the fastest.
    axes: vec3u,
    // The ray's origin, its coordinates in the order of `axes`.
    origin: vec3f,
    // Direction's x and y per z, and 1 per z.
    slope: vec3f,
}

// Three vertices seen along the ray, one coordinate of each in a row.
struct Sheared {
    x: vec3f,
    y: vec3f,
    z: vec3f,
}

// Whether a ray is one that hits anything, see sheer_accel::Ray. False for a NaN.
fn is_traceable(origin: vec3f, direction: vec3f) -> bool {
    let speed = abs(direction);
    let fastest = max(max(speed.x, speed.y), speed.z);
    return all(abs(origin) <= vec3f(COORDINATE_LIMIT)) && all(speed <= vec3f(SPEED_LIMIT)) && fastest >= LEAST_SPEED;
}

fn watertight_ray(origin: vec3f, direction: vec3f) -> WatertightRay {
    let speed = abs(direction);
    var axes = vec3u(0u, 1u, 2u);
    if speed.x >= speed.y && speed.x >= speed.z {
        axes = vec3u(1u, 2u, 0u);
    } else if speed.y >= speed.z {
        axes = vec3u(2u, 0u, 1u);
    }
    // Swapped for a ray against the axis: keeps the winding.
    if direction[axes.z] < 0.0 {
        axes = axes.yxz;
    }
    let inverse = 1.0 / direction[axes.z];
    return WatertightRay(
        axes,
        vec3f(origin[axes.x], origin[axes.y], origin[axes.z]),
        vec3f(direction[axes.x] * inverse, direction[axes.y] * inverse, inverse),
    );
}

// The hit of a triangle, at any distance; `t` is negative (-1, or behind the origin) if there is none.
fn intersect(ray: WatertightRay, triangle: u32) -> Hit {
    return intersect_sheared(ray, sheared_triangle(ray, triangle), triangle);
}

// Where the ray meets the plane of the triangle: the numbers of `intersect` without its test whether that is
// inside. For points that are known to be inside up to rounding. `t` is -1 if the ray lies in the plane.
fn barycentrics(ray: WatertightRay, triangle: u32) -> Hit {
    let corners = sheared_triangle(ray, triangle);
    return weighted(ray, corners, areas_of(corners), triangle);
}

fn sheared_triangle(ray: WatertightRay, triangle: u32) -> Sheared {
    let first = 9u * triangle + ray.axes;
    return sheared(
        ray,
        vec3f(positions[first.x], positions[first.x + 3u], positions[first.x + 6u]),
        vec3f(positions[first.y], positions[first.y + 3u], positions[first.y + 6u]),
        vec3f(positions[first.z], positions[first.z + 3u], positions[first.z + 6u]),
    );
}

// From the permuted coordinates of the three vertices.
fn sheared(ray: WatertightRay, x: vec3f, y: vec3f, z: vec3f) -> Sheared {
    let depth = z - ray.origin.z;
    return Sheared((x - ray.origin.x) - depth * ray.slope.x, (y - ray.origin.y) - depth * ray.slope.y, depth);
}

// Twice the signed areas that the ray's point spans with the edges bc, ca and ab.
fn areas_of(corners: Sheared) -> vec3f {
    let x = corners.x;
    let y = corners.y;
    return x.zxy * y.yzx - y.zxy * x.yzx;
}

fn intersect_sheared(ray: WatertightRay, corners: Sheared, triangle: u32) -> Hit {
    let areas = areas_of(corners);
    // Far from all edges the signs are right even after fusion, which errs by half a unit in the last place
    // of a product.
    let products = abs(corners.x.zxy * corners.y.yzx) + abs(corners.y.zxy * corners.x.yzx);
    let doubtful = abs(areas) <= products * AREA_DOUBT;
    var signs = vec3i(sign(areas));
    if any(doubtful) {
        // One area of each sign, both beyond doubt: no need for the others'.
        if any(areas > vec3f(0.0) & !doubtful) && any(areas < vec3f(0.0) & !doubtful) {
            return no_hit();
        }
        signs = select(signs, exact_signs(corners), doubtful);
    }
    let front = any(signs > vec3i(0));
    if front == any(signs < vec3i(0)) {
        return no_hit();
    }
    if any(signs == vec3i(0)) && !all(signs != vec3i(0) | owned_edges(corners, front)) {
        return no_hit();
    }
    // An area whose sign fusion has spoilt is nothing but rounding.
    return weighted(ray, corners, select(areas, vec3f(0.0), sign(areas) != vec3f(signs)), triangle);
}

// Which edges belong to the triangle where the ray passes through them. It counts as moved by an
// infinitesimal (-e, e^2) in the sheared plane, the fill rule of rasterisers: of all triangles around the
// edge or vertex, as many are hit as if the ray had passed beside it.
fn owned_edges(corners: Sheared, front: bool) -> vec3<bool> {
    let along_x = select(corners.x.zxy, corners.x.yzx, front) - select(corners.x.yzx, corners.x.zxy, front);
    let along_y = select(corners.y.zxy, corners.y.yzx, front) - select(corners.y.yzx, corners.y.zxy, front);
    return along_y > vec3f(0.0) | (along_y == vec3f(0.0) & along_x > vec3f(0.0));
}

fn weighted(ray: WatertightRay, corners: Sheared, rounded_areas: vec3f, triangle: u32) -> Hit {
    var areas = rounded_areas;
    var sum = areas.x + areas.y + areas.z;
    if any(areas == vec3f(0.0)) || sum == 0.0 {
        areas = precise_areas(corners);
        sum = areas.x + areas.y + areas.z;
        if sum == 0.0 {
            return no_hit();
        }
    }
    // The weights before the depth: areas times depths could leave the range of f32.
    let weights = areas * (1.0 / sum);
    let depth = weights.x * corners.z.x + weights.y * corners.z.y + weights.z * corners.z.z;
    return Hit(depth * ray.slope.z, weights.y, weights.z, triangle, sum > 0.0);
}

// The areas where `f32` has lost one, in place of the CPU's `f64`. Halves of 12 bits have exact products,
// fused or not, so that what rounds are differences: an area errs by at most 2^-34 of its larger product, and
// has the right sign.
fn precise_areas(corners: Sheared) -> vec3f {
    let a = corners.x.zxy;
    let b = corners.y.yzx;
    let c = corners.y.zxy;
    let d = corners.x.yzx;
    let a_high = high_half(a);
    let b_high = high_half(b);
    let c_high = high_half(c);
    let d_high = high_half(d);
    let high = a_high * b_high - c_high * d_high;
    let middle = (a_high * (b - b_high) - c_high * (d - d_high)) + ((a - a_high) * b_high - (c - c_high) * d_high);
    let low = (a - a_high) * (b - b_high) - (c - c_high) * (d - d_high);
    let areas = high + (middle + low);
    return select(areas, vec3f(0.0), sign(areas) != vec3f(exact_signs(corners)));
}

// The number cut to the upper 12 bits of its mantissa.
fn high_half(number: vec3f) -> vec3f {
    return bitcast<vec3f>(bitcast<vec3u>(number) & vec3u(0xfffff000u));
}

// Signs of the areas of the sheared vertices without any rounding.
fn exact_signs(corners: Sheared) -> vec3i {
    let x = corners.x;
    let y = corners.y;
    return vec3i(
        product_order(exact_product(x.z, y.y), exact_product(y.z, x.y)),
        product_order(exact_product(x.x, y.z), exact_product(y.x, x.z)),
        product_order(exact_product(x.y, y.x), exact_product(y.y, x.x)),
    );
}

// sign * (high * 2^24 + low) * 2^exponent up to a constant power; `high` has 24 bits, so that larger is
// larger member by member.
struct ExactProduct {
    sign: i32,
    exponent: u32,
    high: u32,
    low: u32,
}

// Numbers below the normal range count as 0.
fn exact_product(a: f32, b: f32) -> ExactProduct {
    let bits = vec2u(bitcast<u32>(a), bitcast<u32>(b));
    let exponents = (bits >> vec2u(23u)) & vec2u(0xffu);
    if any(exponents == vec2u(0u)) {
        return ExactProduct(0, 0u, 0u, 0u);
    }
    let mantissas = (bits & vec2u(0x7fffffu)) | vec2u(0x800000u);
    let upper = mantissas >> vec2u(12u);
    let lower = mantissas & vec2u(0xfffu);
    let middle = upper.x * lower.y + lower.x * upper.y;
    let carried = lower.x * lower.y + ((middle & 0xfffu) << 12u);
    var high = upper.x * upper.y + (middle >> 12u) + (carried >> 24u);
    var low = carried & 0xffffffu;
    var exponent = exponents.x + exponents.y + 1u;
    if high < 0x800000u {
        high = (high << 1u) | (low >> 23u);
        low = (low << 1u) & 0xffffffu;
        exponent -= 1u;
    }
    return ExactProduct(select(1, -1, ((bits.x ^ bits.y) >> 31u) != 0u), exponent, high, low);
}

// The sign of a - b.
fn order_of(a: u32, b: u32) -> i32 {
    return select(select(0, -1, a < b), 1, a > b);
}

fn product_order(a: ExactProduct, b: ExactProduct) -> i32 {
    if a.sign != b.sign {
        return select(-1, 1, a.sign > b.sign);
    }
    var magnitude = order_of(a.exponent, b.exponent);
    if magnitude == 0 {
        magnitude = order_of(a.high, b.high);
    }
    if magnitude == 0 {
        magnitude = order_of(a.low, b.low);
    }
    return magnitude * a.sign;
}
