//! Which triangle of a frame is which of another: told by the identity of their objects, as particles are
//! born and die and nodes are hidden from one frame to the next.

use rayon::prelude::*;

use super::Frame;

/// Stands for a triangle that is not in the other frame.
pub const GONE: u32 = u32::MAX;

/// Objects that a task reads at least: some 20 µs.
const LEAST_TASK: usize = 2048;

/// The objects of a frame whose triangles are stored and move, in their order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MovingObjects {
    objects: Vec<Moving>,
    triangle_count: u32,
}

/// An object: what it is, and its first triangle among those that move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Moving {
    id: u32,
    geometry: u32,
    first: u32,
}

impl Moving {
    fn identity(&self) -> (u32, u32) {
        (self.id, self.geometry)
    }
}

impl Frame {
    /// The objects whose triangles are stored from [`Self::static_count`] on.
    #[must_use]
    pub fn moving_objects(&self) -> MovingObjects {
        let counts = self.static_counts();
        let first = counts.triangles as u32 + self.instanced_triangles().len() as u32;
        let moving = self.objects()[counts.objects..].par_iter().with_min_len(LEAST_TASK).map(|object| {
            Moving { id: object.id, geometry: object.geometry, first: object.first_triangle - first }
        });
        let triangle_count = (self.triangles().len() - counts.triangles) as u32;
        MovingObjects { objects: moving.collect(), triangle_count }
    }
}

impl MovingObjects {
    /// For each triangle that moves in this frame its place among those of another frame of the same scene,
    /// [`GONE`] if it is not there. Objects that change their order are taken to be gone.
    #[must_use]
    pub fn successors(&self, later: &Self) -> Vec<u32> {
        let mut successors = Vec::with_capacity(self.triangle_count as usize);
        let mut candidates = later.with_ends().peekable();
        for (object, end) in self.with_ends() {
            while candidates.next_if(|(other, _)| other.identity() < object.identity()).is_some() {}
            let found = candidates.next_if(|(other, _)| other.identity() == object.identity());
            let places = found.map_or(0..0, |(other, end)| other.first..end);
            let missing = std::iter::repeat_n(GONE, (end - object.first) as usize);
            successors.extend(places.chain(missing).take((end - object.first) as usize));
        }
        successors
    }

    /// Each object with the end of its triangles.
    fn with_ends(&self) -> impl Iterator<Item = (&Moving, u32)> {
        let ends = self.objects.iter().skip(1).map(|next| next.first);
        self.objects.iter().zip(ends.chain([self.triangle_count]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Objects with their identity and how many triangles they have.
    fn objects(list: &[(u32, u32, u32)]) -> MovingObjects {
        let mut moving = MovingObjects::default();
        for &(id, geometry, count) in list {
            moving.objects.push(Moving { id, geometry, first: moving.triangle_count });
            moving.triangle_count += count;
        }
        moving
    }

    #[test]
    fn triangles_are_told_by_their_objects_as_these_come_and_go() {
        let before = objects(&[(3, 0, 2), (3, 1, 1), (7, 0, 3), (8, 0, 1), (9, 0, 2)]);
        assert_eq!(before.successors(&before), (0..9).collect::<Vec<u32>>());
        let after = objects(&[(2, 0, 1), (3, 1, 1), (5, 0, 2), (7, 0, 3), (9, 0, 2), (10, 0, 4)]);
        assert_eq!(before.successors(&after), [GONE, GONE, 1, 4, 5, 6, GONE, 7, 8]);
        assert_eq!(before.successors(&objects(&[])), [GONE; 9]);
        assert_eq!(objects(&[]).successors(&before), [0; 0]);
        // An object with more or fewer triangles than before, and a changed order, are no harm.
        assert_eq!(objects(&[(1, 0, 3)]).successors(&objects(&[(1, 0, 2)])), [0, 1, GONE]);
        assert_eq!(objects(&[(1, 0, 2)]).successors(&objects(&[(1, 0, 3)])), [0, 1]);
        assert_eq!(objects(&[(5, 0, 1), (2, 0, 1)]).successors(&objects(&[(2, 0, 1), (5, 0, 1)])), [1, GONE]);
    }
}
