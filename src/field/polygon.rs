//! The exact distance to a convex polygon, of which solids are extruded and revolved.

use glam::DVec2;

use super::Graph;
use super::graph::Node;

impl Graph {
    /// The signed distance to a convex polygon in the plane of two coordinates, positive inside. `edges` run
    /// counterclockwise; an edge that is left out bounds nothing, such as the axis of a profile that is revolved.
    ///
    /// With the planes' values i and the distances m to the edges it is 2·max(min i, 0) − min m: inside both are the same.
    pub fn convex_polygon(&mut self, [u, v]: [Node; 2], edges: &[[DVec2; 2]]) -> Node {
        let zero = self.constant(0.0);
        let (mut depth, mut nearest): (Option<Node>, Option<Node>) = (None, None);
        for [from, to] in edges {
            let along = (to - from).normalize_or_zero();
            let form = |graph: &mut Self, direction: DVec2| {
                let (a, b) = (graph.linear(u, direction.x, 0.0), graph.linear(v, direction.y, -direction.dot(*from)));
                graph.add(a, b)
            };
            let (plane, reached) = (form(self, along.perp()), form(self, along));
            let (before, beyond) = (self.neg(reached), self.linear(reached, 1.0, -from.distance(*to)));
            let past = self.max(before, beyond);
            let past = self.max(past, zero);
            let away = self.length(&[plane, past]);
            depth = Some(depth.map_or(plane, |depth| self.min(depth, plane)));
            nearest = Some(nearest.map_or(away, |nearest| self.min(nearest, away)));
        }
        let (Some(depth), Some(nearest)) = (depth, nearest) else { return zero };
        let inside = self.max(depth, zero);
        let inside = self.linear(inside, 2.0, 0.0);
        self.sub(inside, nearest)
    }
}
