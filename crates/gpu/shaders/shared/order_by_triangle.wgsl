// As a rasteriser draws them and the CPU hands them to methods.
#import shared/drawn

fn comes_before(fragment: Fragment, other: Fragment) -> bool {
    return fragment.hit.triangle < other.hit.triangle;
}
