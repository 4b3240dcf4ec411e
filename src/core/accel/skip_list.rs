//! The order in which a small scene tests its shapes against a batch of rays, with boxes around groups of close shapes.
//! The content of a box that no ray of the batch meets is skipped; otherwise it is tested against the rays that meet
//! the box.
//!
//! It is a hierarchy in depth-first order. The surface area heuristic (MacDonald and Booth, Heuristics for Ray Tracing
//! Using Space Subdivision, 1990) decides which boxes pay off, for a batch: by the probability that any of its rays
//! meets the box.

use std::cmp::Ordering;

use arrayvec::ArrayVec;

use crate::math::Aabb;
use crate::math::lanes::LANES;

/// A step of a walk through the list.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Step {
    /// Test the item with this number.
    Item(u32),
    /// Continue at the step `end` if no ray meets the box.
    Box { bounds: Aabb, end: u32 },
}

/// The most nested boxes.
const DEEPEST: usize = 32;

/// A walk of a batch of rays through the steps.
pub(super) struct Walk<'a> {
    steps: &'a [Step],
    next: usize,
    /// The innermost box around the next step.
    inner: Within,
    outer: ArrayVec<Within, DEEPEST>,
}

/// A box whose content a walk is testing.
#[derive(Clone, Copy)]
struct Within {
    /// The first step after the box's content.
    end: usize,
    /// The rays that meet the box and all boxes around it, a bit each.
    rays: u32,
}

impl<'a> Walk<'a> {
    #[inline(always)]
    pub fn new(steps: &'a [Step]) -> Self {
        Self {
            steps,
            next: 0,
            inner: Within {
                end: steps.len(),
                rays: u32::MAX,
            },
            outer: ArrayVec::new(),
        }
    }

    /// The next item, and the rays among `active` to be tested against it, a bit each: those that meet all boxes around
    /// it, whatever the other rays meet. `meet` gives the rays that meet a box.
    #[inline(always)]
    pub fn next(&mut self, active: u32, meet: impl Fn(&Aabb) -> u32) -> Option<(usize, u32)> {
        loop {
            let rays = active & self.inner.rays;
            if self.next >= self.inner.end || rays == 0 {
                self.next = self.inner.end;
                self.inner = self.outer.pop()?;
                continue;
            }
            let step = self.steps.get(self.next)?;
            self.next += 1;
            match step {
                Step::Item(number) => return Some((*number as usize, rays)),
                Step::Box { bounds, end } => {
                    let end = *end as usize;
                    match meet(bounds) & rays {
                        0 => self.next = end,
                        rays => {
                            let is_held = self.outer.try_push(self.inner).is_ok();
                            debug_assert!(is_held, "no more than DEEPEST boxes are inside each other");
                            self.inner = Within { end, rays };
                        }
                    }
                }
            }
        }
    }
}

/// An item to be tested.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item {
    pub number: u32,
    /// World bounds.
    pub bounds: Aabb,
    /// The cost of a test of all lanes, in units of a test of a shape that is a box.
    pub cost: f32,
}

/// The cost of a test of a box in world space, in those units.
const BOX_COST: f32 = 0.4;

/// From this number of items on, sets are divided in the middle, because most batches meet both halves of any division.
const MANY: usize = 64;

/// The items below a node of the hierarchy, which has a box if the box pays off.
struct Plan {
    bounds: Aabb,
    has_box: bool,
    /// The cost of the tests that follow whenever the box around the node is met.
    always: f32,
    /// The expected cost of the tests within boxes below the node.
    sometimes: f32,
    content: Content,
}

enum Content {
    Item(u32),
    Two(Box<[Plan; 2]>),
}

/// Appends the steps for `items` and returns their expected cost. Rays are expected in the box `whole`.
pub(super) fn append_steps(steps: &mut Vec<Step>, items: &mut [Item], whole: &Aabb) -> f32 {
    if items.is_empty() {
        return 0.0;
    }
    let plan = Plan::new(items, whole);
    plan.append_to(steps, 0);
    plan.always + plan.sometimes
}

/// The region of rays that begin on `items`: the box of their centres, and half the size of the median item around it.
/// The bounds would be worse: beside a wide ground all shapes in a room are small.
pub(super) fn place_of_rays(items: &[Item]) -> Aabb {
    let centers = Aabb::from_points(items.iter().map(|item| item.bounds.center()));
    let mut sizes: Vec<f32> = items.iter().map(|item| item.bounds.extent().max_element()).collect();
    sizes.sort_unstable_by(f32::total_cmp);
    let around = 0.5 * sizes.get(items.len() / 2).copied().unwrap_or(0.0);
    Aabb {
        min: centers.min - around,
        max: centers.max + around,
    }
}

impl Plan {
    fn new(items: &mut [Item], whole: &Aabb) -> Self {
        let bounds = union(items);
        let (mut always, mut sometimes, content) = match items {
            [item] => (item.cost, 0.0, Content::Item(item.number)),
            _ => {
                let middle = split(items, whole);
                let (first, second) = items.split_at_mut(middle);
                let [a, b] = [first, second].map(|part| Self::new(part, whole));
                let (always, sometimes) = (a.always + b.always, a.sometimes + b.sometimes);
                (always, sometimes, Content::Two(Box::new([a, b])))
            }
        };
        let behind_box = chance(&bounds, whole) * always;
        let has_box = BOX_COST + behind_box < always;
        if has_box {
            (always, sometimes) = (BOX_COST, sometimes + behind_box);
        }
        Self {
            bounds,
            has_box,
            always,
            sometimes,
            content,
        }
    }

    /// Appends the steps. `depth` is the number of boxes around them.
    fn append_to(&self, steps: &mut Vec<Step>, depth: usize) {
        let place = steps.len();
        let has_box = self.has_box && depth < DEEPEST;
        if has_box {
            steps.push(Step::Box {
                bounds: self.bounds,
                end: 0,
            });
        }
        match &self.content {
            Content::Item(number) => steps.push(Step::Item(*number)),
            Content::Two(parts) => {
                let depth = depth + usize::from(has_box);
                parts.iter().for_each(|part| part.append_to(steps, depth));
            }
        }
        let after = steps.len() as u32;
        if has_box && let Step::Box { end, .. } = &mut steps[place] {
            *end = after;
        }
    }
}

/// Sorts two or more items along an axis and returns where the second part begins.
fn split(items: &mut [Item], whole: &Aabb) -> usize {
    let sort = |items: &mut [Item], axis: usize| {
        items.sort_unstable_by(|a, b| in_order(a, b, axis));
    };
    if items.len() > MANY {
        let centers = Aabb::from_points(items.iter().map(|item| item.bounds.center()));
        let axis = centers.extent().max_position();
        let middle = items.len() / 2;
        items.select_nth_unstable_by(middle, |a, b| in_order(a, b, axis));
        return middle;
    }
    let (mut best, mut least) = ((0, items.len() / 2), f32::INFINITY);
    for axis in 0..3 {
        sort(items, axis);
        let cost = |item: &Item, (bounds, cost): &mut (Aabb, f32)| {
            *bounds = bounds.union(item.bounds);
            *cost += item.cost;
            chance(bounds, whole) * *cost
        };
        let mut so_far = (Aabb::EMPTY, 0.0);
        let first: Vec<f32> = items.iter().map(|item| cost(item, &mut so_far)).collect();
        let mut so_far = (Aabb::EMPTY, 0.0);
        for middle in (1..items.len()).rev() {
            let both = first[middle - 1] + cost(&items[middle], &mut so_far);
            if both < least {
                (best, least) = ((axis, middle), both);
            }
        }
    }
    sort(items, best.0);
    best.1
}

/// Items by their centres along an axis, and by their numbers where these are the same.
fn in_order(a: &Item, b: &Item, axis: usize) -> Ordering {
    let [first, second] = [a, b].map(|item| item.bounds.center()[axis]);
    first.total_cmp(&second).then(a.number.cmp(&b.number))
}

/// The probability that any ray of a batch somewhere in `whole` meets a box.
fn chance(bounds: &Aabb, whole: &Aabb) -> f32 {
    let share = (bounds.half_area() / whole.half_area()).clamp(0.0, 1.0);
    // Points without extent have no such share.
    let missed = if share.is_finite() { 1.0 - share } else { 0.0 };
    1.0 - missed.powi(LANES as i32)
}

fn union(items: &[Item]) -> Aabb {
    items.iter().fold(Aabb::EMPTY, |all, item| all.union(item.bounds))
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    fn row(count: u32, gap: f32) -> Vec<Item> {
        (0..count)
            .map(|number| {
                let corner = Vec3::X * gap * number as f32;
                Item {
                    number,
                    bounds: Aabb::from_points([corner, corner + Vec3::splat(0.1)]),
                    cost: 1.0,
                }
            })
            .collect()
    }

    fn steps(mut items: Vec<Item>, size: f32) -> Vec<Step> {
        let whole = Aabb::from_points([Vec3::ZERO, Vec3::splat(size)]);
        let mut steps = Vec::new();
        append_steps(&mut steps, &mut items, &whole);
        steps
    }

    #[test]
    fn every_item_is_tested_within_its_boxes() {
        let items = row(50, 0.2);
        let steps = steps(items.clone(), 20.0);
        let mut seen = Vec::new();
        let mut around: Vec<(Aabb, u32)> = Vec::new();
        for (place, step) in (0..).zip(&steps) {
            around.retain(|(_, end)| *end > place);
            match step {
                Step::Item(number) => {
                    seen.push(*number);
                    assert!(
                        around
                            .iter()
                            .all(|(bounds, _)| bounds.contains(&items[*number as usize].bounds))
                    );
                }
                Step::Box { bounds, end } => {
                    assert!(*end > place + 1 && *end as usize <= steps.len());
                    assert!(around.iter().all(|(_, outer)| end <= outer));
                    around.push((*bounds, *end));
                }
            }
        }
        seen.sort_unstable();
        assert!(seen.into_iter().eq(0..50));
        assert!(steps.len() > 60, "{}", steps.len());
    }

    /// Books on a shelf: their centres are on a line.
    #[test]
    fn a_row_has_boxes_where_its_own_rays_are() {
        let mut items = row(50, 0.2);
        let whole = place_of_rays(&items);
        assert!(whole.half_area() > 1.0, "{whole:?}");
        let mut steps = Vec::new();
        let cost = append_steps(&mut steps, &mut items, &whole);
        assert!(cost < 35.0 && steps.len() > 60, "{cost} {}", steps.len());
    }

    #[test]
    fn a_ray_is_tested_within_the_boxes_that_it_meets() {
        let steps = steps(row(50, 0.2), 20.0);
        let around = |number: u32, lane: u32| number.is_multiple_of(lane + 2);
        let bounds: Vec<Aabb> = row(50, 0.2).iter().map(|item| item.bounds).collect();
        // The rays meet the boxes around certain items.
        let meet = |lanes: u32, outer: &Aabb| {
            let meets =
                |lane: u32| (0..50).any(|number| around(number, lane) && outer.contains(&bounds[number as usize]));
            (0..4)
                .filter(|&lane| lanes >> lane & 1 == 1 && meets(lane))
                .fold(0, |met, lane| met | 1 << lane)
        };
        let tested = |active: u32, lane: u32| {
            let mut walk = Walk::new(&steps);
            let mut tested = Vec::new();
            while let Some((item, rays)) = walk.next(active, |outer| meet(active, outer)) {
                if rays >> lane & 1 == 1 {
                    tested.push(item);
                }
            }
            tested
        };
        for lane in 0..4 {
            let alone = tested(1 << lane, lane);
            assert_eq!(alone, tested(0xf, lane));
            assert!(
                (0..50)
                    .filter(|&number| around(number, lane))
                    .all(|number| alone.contains(&(number as usize)))
            );
        }
        assert!(tested(8, 3).len() < tested(1, 0).len());
    }

    /// Two boxes that end at the same step, a box after them, and an item after all.
    #[test]
    fn walks_leave_boxes_where_they_end() {
        let bounds = |x: f32| Aabb::from_points([Vec3::X * x]);
        let steps = [
            Step::Box {
                bounds: bounds(0.0),
                end: 4,
            },
            Step::Item(0),
            Step::Box {
                bounds: bounds(1.0),
                end: 4,
            },
            Step::Item(1),
            Step::Box {
                bounds: bounds(2.0),
                end: 6,
            },
            Step::Item(2),
            Step::Item(3),
        ];
        let walked = |rays: [u32; 3], mut active: u32, first_ends: bool| {
            let mut walk = Walk::new(&steps);
            let mut found = Vec::new();
            while let Some(next) = walk.next(active, |bounds| rays[bounds.min.x as usize]) {
                found.push(next);
                if first_ends {
                    active &= !1;
                }
            }
            assert_eq!(walk.next(active, |_| 0), None);
            found
        };
        assert_eq!(walked([3, 1, 2], 3, false), [(0, 3), (1, 1), (2, 2), (3, 3)]);
        assert_eq!(walked([1, 1, 2], 3, true), [(0, 1), (2, 2), (3, 2)]);
        assert_eq!(walked([2, 1, 0], 3, false), [(0, 2), (3, 3)]);
        assert_eq!(walked([3, 3, 3], 0, false), []);
        assert_eq!(Walk::new(&[]).next(3, |_| 3), None);
    }

    /// Each item is twice as large as the one before.
    #[test]
    fn no_more_boxes_are_inside_each_other_than_a_walk_can_hold() {
        let mut items: Vec<Item> = (0..60)
            .map(|number| Item {
                number,
                bounds: Aabb::from_points([Vec3::ZERO, Vec3::splat(2f32.powi(number as i32 - 30))]),
                cost: 1.0,
            })
            .collect();
        let whole = Aabb::from_points([Vec3::ZERO, Vec3::splat(1e9)]);
        let mut steps = Vec::new();
        append_steps(&mut steps, &mut items, &whole);
        let mut walk = Walk::new(&steps);
        let mut seen = 0;
        while walk.next(1, |_| 1).is_some() {
            seen += 1;
        }
        assert_eq!(seen, 60);
    }

    #[test]
    fn there_are_no_boxes_around_what_most_batches_meet() {
        assert_eq!(steps(row(4, 0.2), 0.2).len(), 4);
        let flat = Item {
            number: 7,
            bounds: Aabb::from_points([Vec3::ZERO]),
            cost: 1.0,
        };
        assert_eq!(steps(vec![flat], 0.0), [Step::Item(7)]);
        assert!(steps(Vec::new(), 1.0).is_empty());
    }
}
