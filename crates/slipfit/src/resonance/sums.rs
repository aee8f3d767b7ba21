//! Normal equations of a curve, accumulated for many points at a time.

use super::block::Block;
use super::lanes::{Lanes, PIECE, Points};
use super::response::{BG_IM, BG_RE, DELAY, FLOOR, ModelResponse, OFFSET, PHASE, X_0, X_F};
use crate::motion::steady::Phasor;
use crate::motion::steady::fundamental::Follower;
use crate::numeric::products::{Products, WIDTH};
use crate::numeric::trig;

/// Sums of a block over the `columns` of its parameters, with the residual last; `None` if the model does not exist or
/// the sum of squares exceeds `limit`.
pub(super) fn products(block: &Block, at: ModelResponse, columns: &[usize], limit: f64) -> Option<Products> {
    let rotation = Phasor::from_polar(1.0, at.phase);
    let products = Products::new(columns.len() + 1);
    let follower = Follower::for_fit(block.work.remaining());
    let pass = Pass { block, columns, at, rotation, limit, products, follower };
    let (sums, work) = crate::numeric::dispatch(pass);
    block.work.spend(block.len(), work);
    sums
}

struct Pass<'a> {
    block: &'a Block,
    columns: &'a [usize],
    at: ModelResponse,
    /// Rotation by the phase offset.
    rotation: Phasor,
    limit: f64,
    products: Products,
    follower: Follower,
}

impl pulp::WithSimd for Pass<'_> {
    /// Also returns the work of motions that stop.
    type Output = (Option<Products>, u64);

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) -> Self::Output {
        if const { trig::has_fused::<S>() } {
            self.sums::<S, true>(simd)
        } else {
            self.sums::<S, false>(simd)
        }
    }
}

impl Pass<'_> {
    #[inline(always)]
    fn sums<S: pulp::Simd, const FUSED: bool>(mut self, simd: S) -> (Option<Products>, u64) {
        let exists = self.add_up::<S, FUSED>(simd).is_some();
        (exists.then_some(self.products), self.follower.work())
    }

    /// `None` if the model does not exist, the limit is exceeded, or the work is used up.
    #[inline(always)]
    fn add_up<S: pulp::Simd, const FUSED: bool>(&mut self, simd: S) -> Option<()> {
        let mut points = Points::new();
        let mut lanes = Lanes::new();
        let n = self.columns.len();
        let mut next = 0;
        loop {
            next = points.gather(self.block, &self.at, next);
            if points.count == 0 {
                return Some(());
            }
            lanes.respond::<FUSED>(&self.at, &points, &mut self.follower)?;
            self.rows(&points, &mut lanes);
            if self.block.complex {
                self.products.add(simd);
            } else {
                self.products.add_halves(simd);
            }
            if self.limit < f64::INFINITY && self.products.total(n, n) > self.limit {
                return None;
            }
        }
    }
}

impl Pass<'_> {
    /// Instrument terms, residuals, and the rows of the Jacobian.
    #[inline(always)]
    fn rows(&mut self, points: &Points, lanes: &mut Lanes) {
        let at = &self.at;
        for k in 0..PIECE {
            lanes.by_re[X_0][k] *= points.level[k];
            lanes.by_im[X_0][k] *= points.level[k];
        }
        if let Some([through, scale]) = at.ratio {
            for k in 0..PIECE {
                lanes.by_re[X_0][k] += lanes.by_re[X_F][k] * through;
                lanes.by_im[X_0][k] += lanes.by_im[X_F][k] * through;
                lanes.by_re[X_F][k] *= scale;
                lanes.by_im[X_F][k] *= scale;
            }
        }
        // Products are independent of the phase, so the data are rotated instead of the model.
        let (mut cos, mut sin) = ([self.rotation.re; PIECE], [self.rotation.im; PIECE]);
        if at.delay != 0.0 {
            for k in 0..PIECE {
                (sin[k], cos[k]) = trig::sin_cos(at.phase - (points.omega[k] - at.centre) * at.delay);
            }
        }
        // A background to which the delay also applies rotates relative to the oscillator by the phase offset alone.
        let (across, along) = if at.background_delayed {
            ([self.rotation.re; PIECE], [self.rotation.im; PIECE])
        } else {
            (cos, sin)
        };
        let (mut background_re, mut background_im) = ([0.0; PIECE], [0.0; PIECE]);
        let (x, y) = (at.background.re, at.background.im);
        for k in 0..PIECE {
            background_re[k] = x * across[k] + y * along[k];
            background_im[k] = y * across[k] - x * along[k];
        }
        let delayed = if at.background_delayed { 1.0 } else { 0.0 };
        let n = self.columns.len();
        let rows = &mut self.products.rows;
        for (row, &j) in rows.iter_mut().zip(self.columns) {
            let [re, im] = halves(row);
            for k in 0..PIECE {
                (re[k], im[k]) = match j {
                    PHASE => (-lanes.im[k], lanes.re[k]),
                    DELAY => {
                        let t = points.omega[k] - at.centre;
                        (
                            (lanes.im[k] + delayed * background_im[k]) * t,
                            -(lanes.re[k] + delayed * background_re[k]) * t,
                        )
                    }
                    BG_RE => (across[k], -along[k]),
                    BG_IM => (along[k], across[k]),
                    // For amplitudes only, see below.
                    OFFSET | FLOOR => (0.0, 0.0),
                    _ => (lanes.by_re[j][k], lanes.by_im[j][k]),
                };
            }
        }
        if self.block.complex {
            for row in rows[..n].iter_mut().filter(|_| !points.unit_weights) {
                let [re, im] = halves(row);
                for k in 0..PIECE {
                    re[k] *= points.root_weight[k];
                    im[k] *= points.root_weight[k];
                }
            }
            let [re, im] = halves(&mut rows[n]);
            for k in 0..PIECE {
                let (x, y) = (points.re[k], points.im[k]);
                re[k] = (x * cos[k] + y * sin[k] - background_re[k] - lanes.re[k]) * points.root_weight[k];
                im[k] = (y * cos[k] - x * sin[k] - background_im[k] - lanes.im[k]) * points.root_weight[k];
            }
            return;
        }
        for k in 0..PIECE {
            lanes.re[k] += background_re[k];
            lanes.im[k] += background_im[k];
        }
        let (mut along_re, mut along_im) = ([0.0; PIECE], [0.0; PIECE]);
        let (mut read, mut by_square) = ([0.0; PIECE], [0.0; PIECE]);
        let noisy = self.block.rice > 0.0;
        for k in 0..PIECE {
            let square = lanes.re[k] * lanes.re[k] + lanes.im[k] * lanes.im[k] + at.floor;
            let size = if square > 0.0 { square.sqrt() } else { 0.0 };
            read[k] = size;
            let over = if size > 0.0 { 1.0 / size } else { 0.0 };
            (along_re[k], along_im[k]) = (lanes.re[k] * over, lanes.im[k] * over);
            by_square[k] = 0.5 * over;
        }
        if noisy {
            for k in 0..PIECE {
                let size = read[k];
                read[k] = self.block.read(size, points.index[k]);
                // d read/d size; the excess is nearly constant.
                let slope = size / read[k];
                along_re[k] *= slope;
                along_im[k] *= slope;
                by_square[k] *= slope;
            }
        }
        for (row, &j) in rows[..n].iter_mut().zip(self.columns) {
            let [re, im] = halves(row);
            if j == OFFSET {
                re.copy_from_slice(&points.root_weight);
                continue;
            }
            if j == FLOOR {
                for k in 0..PIECE {
                    re[k] = by_square[k] * points.root_weight[k];
                }
                continue;
            }
            for k in 0..PIECE {
                re[k] = (along_re[k] * re[k] + along_im[k] * im[k]) * points.root_weight[k];
            }
        }
        for k in 0..PIECE {
            rows[n][k] = (points.re[k] - read[k] - at.offset) * points.root_weight[k];
        }
    }
}

#[inline(always)]
fn halves(row: &mut [f64; WIDTH]) -> [&mut [f64]; 2] {
    let (re, im) = row.split_at_mut(PIECE);
    [re, im]
}
