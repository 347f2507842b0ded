// The order of `chunks` for methods that take fragments as a rasteriser draws them and as the CPU hands them
// over.
#import shared/drawn

fn comes_before(fragment: Fragment, other: Fragment) -> bool {
    return fragment.hit.triangle < other.hit.triangle;
}
