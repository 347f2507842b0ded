//! Circles in a directed graph.

use std::collections::{BTreeSet, VecDeque};

/// The shortest circle of each strongly connected component with more than one node (Tarjan 1972), with all
/// nodes of the component.
pub(crate) fn circles(edges: &[BTreeSet<usize>]) -> Vec<Circle> {
    let mut search =
        Search { edges, index: vec![None; edges.len()], low: vec![0; edges.len()], ..Search::default() };
    for node in 0..edges.len() {
        if search.index[node].is_none() {
            search.visit(node);
        }
    }
    let circles = search.components.into_iter().filter(|nodes| nodes.len() > 1);
    circles.map(|nodes| Circle { shortest: shortest(edges, &nodes), nodes }).collect()
}

#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Circle {
    /// All that reach one another.
    pub(crate) nodes: BTreeSet<usize>,
    /// The nodes of a shortest way round.
    pub(crate) shortest: Vec<usize>,
}

#[derive(Default)]
struct Search<'a> {
    edges: &'a [BTreeSet<usize>],
    index: Vec<Option<usize>>,
    low: Vec<usize>,
    stack: Vec<usize>,
    count: usize,
    components: Vec<BTreeSet<usize>>,
}

impl Search<'_> {
    fn visit(&mut self, node: usize) {
        let own = self.count;
        self.count += 1;
        (self.index[node], self.low[node]) = (Some(own), own);
        self.stack.push(node);
        for &next in &self.edges[node] {
            match self.index[next] {
                None => {
                    self.visit(next);
                    self.low[node] = self.low[node].min(self.low[next]);
                }
                Some(index) if self.stack.contains(&next) => self.low[node] = self.low[node].min(index),
                Some(_) => {}
            }
        }
        if self.low[node] == own {
            let start = self.stack.iter().position(|&stacked| stacked == node).unwrap_or(0);
            self.components.push(self.stack.split_off(start).into_iter().collect());
        }
    }
}

fn shortest(edges: &[BTreeSet<usize>], nodes: &BTreeSet<usize>) -> Vec<usize> {
    let round = |&start: &usize| way_back(edges, nodes, start);
    nodes.iter().filter_map(round).min_by_key(Vec::len).unwrap_or_default()
}

/// Breadth first from a node until an edge leads back to it.
fn way_back(edges: &[BTreeSet<usize>], nodes: &BTreeSet<usize>, start: usize) -> Option<Vec<usize>> {
    let mut seen = BTreeSet::from([start]);
    let mut ways = VecDeque::from([vec![start]]);
    while let Some(way) = ways.pop_front() {
        let last = *way.last()?;
        if edges[last].contains(&start) {
            return Some(way);
        }
        for &next in edges[last].iter().filter(|next| nodes.contains(next)) {
            if seen.insert(next) {
                ways.push_back(way.iter().copied().chain([next]).collect());
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn graph(edges: &[&[usize]]) -> Vec<BTreeSet<usize>> {
        edges.iter().map(|ends| ends.iter().copied().collect()).collect()
    }

    #[test]
    fn a_graph_without_circles_has_none() {
        assert_eq!(circles(&graph(&[&[1, 2], &[3], &[3], &[]])), []);
    }

    #[test]
    fn each_component_gives_its_shortest_way_round() {
        // 0 → 1 → 2 → 0 with a short cut 1 → 0, and 4 ⇄ 5 apart from it.
        let found = circles(&graph(&[&[1], &[2, 0], &[0, 3], &[], &[5, 3], &[4]]));
        let nodes: Vec<Vec<usize>> =
            found.iter().map(|circle| circle.nodes.iter().copied().collect()).collect();
        assert_eq!(nodes, [vec![0, 1, 2], vec![4, 5]]);
        assert_eq!(found[0].shortest, [0, 1]);
        assert_eq!(found[1].shortest, [4, 5]);
    }
}
