//! The predicted visibility of a light's cells, and which of them are traced.

/// What a receiver sees of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cell {
    Clear,
    Blocked,
    /// Between: never taken from a prediction.
    Partial,
}

/// Whether a cell's prediction stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Trust {
    /// It does, unless a neighbour's turns out to be wrong.
    Trusted,
    /// It is to be traced, or was.
    Traced,
    /// It does: a blocker lies before its very sample.
    Covered,
}

/// The visibility image of a receiver (§5.2): predicted first, then corrected as
/// cells are traced.
#[derive(Debug)]
pub(crate) struct Prediction {
    side: u32,
    cells: Vec<Cell>,
    trust: Vec<Trust>,
    /// Cells to be traced next.
    todo: Vec<usize>,
    next: Vec<usize>,
}

impl Prediction {
    pub(crate) const fn new(side: u32) -> Self {
        Self { side, cells: Vec::new(), trust: Vec::new(), todo: Vec::new(), next: Vec::new() }
    }

    pub(crate) const fn side(&self) -> u32 {
        self.side
    }

    /// Forgets what was marked: everything is clear.
    pub(crate) fn clear(&mut self) {
        let count = (self.side * self.side) as usize;
        self.cells.clear();
        self.cells.resize(count, Cell::Clear);
        self.trust.clear();
        self.trust.resize(count, Trust::Trusted);
        self.todo.clear();
    }

    /// Marks a cell that a blocker lies in front of; if before its sample, and all of
    /// its light is taken, there is no need of a ray.
    pub(crate) fn mark(&mut self, cell: usize, kind: Cell, is_sample: bool) {
        let now = &mut self.cells[cell];
        *now = if *now == Cell::Clear || *now == kind { kind } else { Cell::Partial };
        if is_sample && kind == Cell::Blocked {
            self.trust[cell] = Trust::Covered;
        }
    }

    /// Takes all cells for uncertain.
    pub(crate) fn trace_all(&mut self) {
        self.trust.fill(Trust::Traced);
        self.todo.clear();
        self.todo.extend(0..self.trust.len());
    }

    /// Takes the cells on the light's border for uncertain, those that any of their
    /// eight neighbours differs from, and those that are neither clear nor blocked.
    pub(crate) fn trace_edges(&mut self) {
        self.todo.clear();
        for index in 0..self.cells.len() {
            let is_known =
                self.trust[index] == Trust::Covered && self.cells[index] == Cell::Blocked;
            if !is_known && self.is_uncertain(index) {
                self.trust[index] = Trust::Traced;
                self.todo.push(index);
            }
        }
    }

    fn is_uncertain(&self, index: usize) -> bool {
        let (side, cell) = (self.side as usize, self.cells[index]);
        let (x, y) = (index % side, index / side);
        let is_border = x == 0 || y == 0 || x + 1 == side || y + 1 == side;
        is_border
            || cell == Cell::Partial
            || [index - side, index, index + side]
                .iter()
                .any(|&row| self.cells[row - 1..=row + 1].iter().any(|&other| other != cell))
    }

    /// The cells to be traced now; none if all is settled.
    pub(crate) fn todo(&self) -> &[usize] {
        &self.todo
    }

    /// Takes what the rays of [`Self::todo`] met, and puts the neighbours of those
    /// that were predicted wrongly on the next list. Tells how many were.
    pub(crate) fn settle(&mut self, traced: impl Iterator<Item = Cell>) -> u64 {
        let mut wrong = 0;
        let mut todo = std::mem::take(&mut self.todo);
        for (&index, cell) in todo.iter().zip(traced) {
            if std::mem::replace(&mut self.cells[index], cell) != cell {
                wrong += 1;
                self.doubt_neighbours(index);
            }
        }
        todo.clear();
        self.todo = std::mem::replace(&mut self.next, todo);
        wrong
    }

    fn doubt_neighbours(&mut self, index: usize) {
        let side = self.side as usize;
        let near = |at: usize| at.saturating_sub(1)..(at + 2).min(side);
        for y in near(index / side) {
            for x in near(index % side) {
                let other = y * side + x;
                if self.trust[other] == Trust::Trusted {
                    self.trust[other] = Trust::Traced;
                    self.next.push(other);
                }
            }
        }
    }

    /// The cells as they are known.
    pub(crate) fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// Whether a cell was traced.
    pub(crate) fn is_traced(&self, index: usize) -> bool {
        self.trust[index] == Trust::Traced
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 8 × 8 cells, of which those in columns 0 to 3 are blocked.
    fn half() -> Prediction {
        let mut prediction = Prediction::new(8);
        prediction.clear();
        (0..64).filter(|index| index % 8 < 4).for_each(|cell| {
            prediction.mark(cell, Cell::Blocked, false);
        });
        prediction
    }

    fn picture(prediction: &Prediction) -> Vec<String> {
        let traced = |index| if prediction.is_traced(index) { 'x' } else { '.' };
        (0..8).map(|row| (0..8).map(|column| traced(8 * row + column)).collect()).collect()
    }

    #[test]
    fn edges_and_the_border_are_traced() {
        let mut prediction = half();
        prediction.trace_edges();
        let mut rows = vec!["x..xx..x"; 8];
        (rows[0], rows[7]) = ("xxxxxxxx", "xxxxxxxx");
        assert_eq!(picture(&prediction), rows);
        assert_eq!(prediction.todo().len(), 16 + 6 * 4);
        // As predicted: nothing spreads.
        let seen: Vec<Cell> = prediction.todo().iter().map(|&i| prediction.cells()[i]).collect();
        assert_eq!(prediction.settle(seen.into_iter()), 0);
        assert!(prediction.todo().is_empty());
    }

    #[test]
    fn what_was_predicted_wrongly_spreads() {
        let mut prediction = half();
        prediction.trace_edges();
        // The edge has moved by one cell to the left.
        let truth = |index: usize| if index % 8 < 3 { Cell::Blocked } else { Cell::Clear };
        let mut rounds = 0;
        while !prediction.todo().is_empty() {
            let seen: Vec<Cell> = prediction.todo().iter().map(|&index| truth(index)).collect();
            prediction.settle(seen.into_iter());
            rounds += 1;
        }
        assert_eq!(rounds, 2);
        assert!((0..64).all(|index| prediction.cells()[index] == truth(index)));
        let mut rows = vec!["x.xxx..x"; 8];
        (rows[0], rows[7]) = ("xxxxxxxx", "xxxxxxxx");
        assert_eq!(picture(&prediction), rows);
    }

    #[test]
    fn partial_cells_are_traced_and_covered_ones_are_not() {
        let mut prediction = Prediction::new(8);
        prediction.clear();
        (0..64).for_each(|cell| prediction.mark(cell, Cell::Blocked, cell % 8 == 0));
        prediction.mark(27, Cell::Partial, true);
        prediction.trace_edges();
        assert_eq!(prediction.cells()[27], Cell::Partial);
        let mut rows = vec![".......x"; 8];
        (rows[0], rows[7]) = (".xxxxxxx", ".xxxxxxx");
        (rows[2], rows[3], rows[4]) = ("..xxx..x", "..xxx..x", "..xxx..x");
        assert_eq!(picture(&prediction), rows);
    }

    #[test]
    fn one_cell_is_all_border() {
        let mut prediction = Prediction::new(1);
        prediction.clear();
        prediction.trace_edges();
        assert_eq!(prediction.todo(), [0]);
        assert_eq!(prediction.settle([Cell::Partial].into_iter()), 1);
        assert!(prediction.todo().is_empty());
    }
}
