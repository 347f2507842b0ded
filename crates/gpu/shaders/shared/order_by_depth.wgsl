// The order of `chunks` for methods that blend their fragments front to back.
#import shared/drawn

fn comes_before(fragment: Fragment, other: Fragment) -> bool {
    return is_in_front(fragment.depth, fragment.hit.triangle, other.depth, other.hit.triangle);
}
