//! Traces in the columns of a batch.

use crate::error::{Error, place};
use crate::options::{Clock, Number, Options, Signal};
use arrow_array::cast::AsArray;
use arrow_array::types::{
    Decimal32Type, Decimal64Type, Decimal128Type, Decimal256Type, DurationMicrosecondType,
    DurationMillisecondType, DurationNanosecondType, DurationSecondType, Float16Type, Float32Type,
    Float64Type, Int8Type, Int16Type, Int32Type, Int64Type, RunEndIndexType, TimestampMicrosecondType,
    TimestampMillisecondType, TimestampNanosecondType, TimestampSecondType, UInt8Type, UInt16Type,
    UInt32Type, UInt64Type,
};
use arrow_array::{
    Array, ArrayRef, ArrowPrimitiveType, Float64Array, OffsetSizeTrait, PrimitiveArray, RecordBatch,
};
use arrow_buffer::{NullBuffer, i256};
use arrow_schema::{DataType, TimeUnit};
use slipfit::SignalKind;
use std::ops::Range;

/// The columns that the options name.
pub(crate) struct Input<'a> {
    pub(crate) signal: Lists<'a>,
    /// Y of a lock-in.
    pub(crate) quadrature: Option<Lists<'a>>,
    pub(crate) kind: SignalKind,
    times: Option<Times<'a>>,
    interval_s: Option<Numbers>,
    frequency_hz: Option<Numbers>,
    min_amplitude: Option<Numbers>,
    pub(crate) unit: &'a str,
}

/// Memory that a thread reuses for every row.
#[derive(Default)]
pub(crate) struct Scratch {
    pub(crate) signal: Vec<f64>,
    pub(crate) quadrature: Vec<f64>,
    pub(crate) times: Vec<f64>,
}

/// Data of one row other than its traces.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RowNumbers {
    /// `None` if times are given in a column.
    pub(crate) interval_s: Option<f64>,
    pub(crate) frequency_hz: Option<f64>,
    pub(crate) min_amplitude: Option<f64>,
    /// Which of the two values before are missing in this row although the options name a column for them.
    pub(crate) missing: [bool; 2],
}

impl RowNumbers {
    /// Codes of warnings about missing numbers; the losses do not depend on them.
    pub(crate) fn warnings(&self) -> [(&'static str, bool); 2] {
        [("no_frequency", self.missing[0]), ("no_min_amplitude", self.missing[1])]
    }
}

impl<'a> Input<'a> {
    pub(crate) fn new(batch: &'a RecordBatch, options: &'a Options) -> Result<Self, Error> {
        let factor = |name: &str| options.factors.get(name).copied().unwrap_or(1.0);
        let lists = |name: &str| {
            let scale = if options.levels { Scale::Level } else { Scale::Factor(factor(name)) };
            Lists::new(name, values(batch, name, NUMBERS)?, scale)
        };
        let number = |number: &Number, convert: Convert, needed| match number {
            Number::Same(value) => Ok(Numbers::Same(*value)),
            Number::Column(name) => Numbers::each(batch, name, factor(name), convert, needed),
        };
        let numbers = |held: &Number| number(held, converted, "a column of numbers");
        let (signal, quadrature) = match &options.signal {
            Signal::Amplitude(name) | Signal::Oscillation(name, _) => (lists(name)?, None),
            Signal::LockIn(x, y) => (lists(x)?, Some(lists(y)?)),
        };
        let (times, interval_s) = match &options.clock {
            Clock::Interval(interval) => {
                let needed = "a column of numbers or durations";
                (None, Some(number(interval, seconds, needed)?))
            }
            Clock::Times(name) => (Some(Times::new(name, values(batch, name, TIMES)?, factor(name))?), None),
        };
        Ok(Self {
            signal,
            quadrature,
            kind: options.signal.kind(),
            times,
            interval_s,
            frequency_hz: options.frequency_hz.as_ref().map(numbers).transpose()?,
            min_amplitude: options.min_amplitude.as_ref().map(numbers).transpose()?,
            unit: &options.unit,
        })
    }

    /// The numbers of a row; an error if the interval is missing or one of them is not above zero.
    pub(crate) fn row_numbers(&self, row: usize) -> Result<RowNumbers, String> {
        let number = |name: &str, numbers: &Option<Numbers>| match numbers {
            None => Ok(None),
            Some(numbers) => match numbers.get(row) {
                Some(value) if value > 0.0 && value.is_finite() => Ok(Some(value)),
                Some(value) => Err(format!("{name} = {value} must be a positive number")),
                None => Err(format!("{name} is null")),
            },
        };
        let is_missing = |numbers: &Option<Numbers>| {
            let held = numbers.as_ref().map(|numbers| numbers.get(row));
            held.is_some_and(|value| value.is_none_or(f64::is_nan))
        };
        let missing = [is_missing(&self.frequency_hz), is_missing(&self.min_amplitude)];
        let unless = |missing: bool, name, numbers| if missing { Ok(None) } else { number(name, numbers) };
        Ok(RowNumbers {
            interval_s: number("dt", &self.interval_s)?,
            frequency_hz: unless(missing[0], "frequency_hz", &self.frequency_hz)?,
            min_amplitude: unless(missing[1], "min_amplitude", &self.min_amplitude)?,
            missing,
        })
    }

    /// The numbers common to all rows, if there are such; [`Options`] checked them.
    pub(crate) fn common_numbers(&self) -> Option<RowNumbers> {
        let same = |numbers: &Option<Numbers>| match numbers {
            None => Some(None),
            Some(Numbers::Same(value)) => Some(Some(*value)),
            Some(Numbers::Each(_)) => None,
        };
        Some(RowNumbers {
            interval_s: same(&self.interval_s)?,
            frequency_hz: same(&self.frequency_hz)?,
            min_amplitude: same(&self.min_amplitude)?,
            missing: [false; 2],
        })
    }

    /// Whether rows hold only amplitudes at constant intervals.
    pub(crate) fn is_plain(&self) -> bool {
        self.quadrature.is_none() && self.times.is_none() && self.min_amplitude.is_none()
    }

    /// The times of a row of `samples` samples, if they are given in a column.
    pub(crate) fn times<'t>(
        &'t self,
        row: usize,
        samples: usize,
        scratch: &'t mut Vec<f64>,
    ) -> Result<Option<&'t [f64]>, String> {
        let Some(times) = &self.times else { return Ok(None) };
        let times = times.get(row, scratch).ok_or("the times are null")?;
        if times.len() != samples {
            return Err(format!("{} times for {samples} samples", times.len()));
        }
        Ok(Some(times))
    }
}

/// What the columns of traces and of their times hold.
const NUMBERS: &str = "a list, a large list or a fixed-size list of numbers";
const TIMES: &str = "a list, a large list or a fixed-size list of numbers, dates or durations";

/// A column whose stored values are those that it means: an extension type, such as a period of pandas, may count
/// anything. Lists may be of one, such as a tensor; their items may not.
fn values<'a>(batch: &'a RecordBatch, name: &str, needed: &'static str) -> Result<&'a ArrayRef, Error> {
    let at = place(batch.schema_ref(), name)?;
    let field = batch.schema_ref().field(at);
    let of_values = match field.data_type() {
        DataType::List(item)
        | DataType::LargeList(item)
        | DataType::FixedSizeList(item, _)
        | DataType::ListView(item)
        | DataType::LargeListView(item) => item,
        _ => field,
    };
    match of_values.extension_type_name() {
        Some(extension) => {
            Err(Error::Extension { name: name.to_owned(), extension: extension.to_owned(), needed })
        }
        None => Ok(batch.column(at)),
    }
}

pub(crate) fn column<'a>(batch: &'a RecordBatch, name: &str) -> Result<&'a ArrayRef, Error> {
    place(batch.schema_ref(), name).map(|at| batch.column(at))
}

/// Position of the values of each row.
struct Places<'a> {
    rows: usize,
    nulls: Option<&'a NullBuffer>,
    offsets: Offsets<'a>,
}

enum Offsets<'a> {
    Small(&'a [i32]),
    Large(&'a [i64]),
    Fixed(usize),
    /// Rows in any order, as in views and encodings; those without values are null.
    Each(Vec<Option<Range<usize>>>),
    /// No row has values.
    NoValues,
}

impl<'a> Places<'a> {
    /// The positions, and the values of all rows; `None` if this is not a list.
    fn new(lists: &'a ArrayRef) -> Option<(Self, &'a ArrayRef)> {
        let (offsets, values) = match lists.data_type() {
            DataType::List(_) => {
                let held = lists.as_list::<i32>();
                (Offsets::Small(held.value_offsets()), held.values())
            }
            DataType::LargeList(_) => {
                let held = lists.as_list::<i64>();
                (Offsets::Large(held.value_offsets()), held.values())
            }
            DataType::FixedSizeList(_, size) => {
                let held = lists.as_fixed_size_list();
                // Slices of a fixed-size list have sliced values.
                (Offsets::Fixed(usize::try_from(*size).unwrap_or(0)), held.values())
            }
            DataType::ListView(_) => {
                let held = lists.as_list_view::<i32>();
                (Offsets::Each(views(held.value_offsets(), held.value_sizes())), held.values())
            }
            DataType::LargeListView(_) => {
                let held = lists.as_list_view::<i64>();
                (Offsets::Each(views(held.value_offsets(), held.value_sizes())), held.values())
            }
            DataType::Dictionary(..) | DataType::RunEndEncoded(..) => {
                let (places, held) = encoded(lists)?;
                let (inner, values) = Self::new(held)?;
                let ranges = places.into_iter().map(|place| inner.of(place?)).collect();
                // Nulls of the encoding are among the ranges.
                return Some((
                    Self { rows: lists.len(), nulls: None, offsets: Offsets::Each(ranges) },
                    values,
                ));
            }
            // Tables without declared column types, such as those of pandas, have this type if every row is null
            // or there is no row; this may be a part of a larger table.
            DataType::Null => (Offsets::NoValues, lists),
            _ => return None,
        };
        Some((Self { rows: lists.len(), nulls: lists.nulls(), offsets }, values))
    }

    /// Position of the values of a row; `None` if it is null.
    fn of(&self, row: usize) -> Option<Range<usize>> {
        if self.nulls.is_some_and(|nulls| nulls.is_null(row)) {
            return None;
        }
        // Offsets are not negative and lie within the values: Arrow checks them.
        Some(match self.offsets {
            Offsets::Small(offsets) => offsets[row] as usize..offsets[row + 1] as usize,
            Offsets::Large(offsets) => offsets[row] as usize..offsets[row + 1] as usize,
            Offsets::Fixed(size) => row * size..(row + 1) * size,
            Offsets::Each(ref ranges) => return ranges[row].clone(),
            Offsets::NoValues => return None,
        })
    }
}

/// Positions of the values of views.
fn views<O: OffsetSizeTrait>(offsets: &[O], sizes: &[O]) -> Vec<Option<Range<usize>>> {
    let range = |(offset, size): (&O, &O)| Some(offset.as_usize()..offset.as_usize() + size.as_usize());
    offsets.iter().zip(sizes).map(range).collect()
}

/// The position of each row among the values of an encoded column, `None` for a null of the encoding, and the
/// values; `None` if the column is not encoded.
fn encoded(column: &ArrayRef) -> Option<(Vec<Option<usize>>, &ArrayRef)> {
    Some(match column.data_type() {
        DataType::Dictionary(..) => {
            let held = column.as_any_dictionary();
            let values = held.values();
            let keys = if values.is_empty() { vec![0; held.len()] } else { held.normalized_keys() };
            let place = |(row, key)| (held.keys().is_valid(row) && key < values.len()).then_some(key);
            (keys.into_iter().enumerate().map(place).collect(), values)
        }
        DataType::RunEndEncoded(ends, _) => match ends.data_type() {
            DataType::Int16 => run_ends::<Int16Type>(column)?,
            DataType::Int32 => run_ends::<Int32Type>(column)?,
            _ => run_ends::<Int64Type>(column)?,
        },
        _ => return None,
    })
}

fn run_ends<R: RunEndIndexType>(column: &ArrayRef) -> Option<(Vec<Option<usize>>, &ArrayRef)> {
    let held = column.as_run_opt::<R>()?;
    Some(((0..held.len()).map(|row| Some(held.get_physical_index(row))).collect(), held.values()))
}

/// Values of a type that `convert` takes, plain or encoded.
fn decoded(values: &ArrayRef, convert: Convert) -> Option<Vec<f64>> {
    let Some((places, held)) = encoded(values) else { return convert(values) };
    let held = decoded(held, convert)?;
    Some(places.into_iter().map(|place| place.map_or(f64::NAN, |at| held[at])).collect())
}

/// A list of numbers in each row.
pub(crate) struct Lists<'a> {
    places: Places<'a>,
    values: Values<'a>,
}

/// The numbers of a row in the type they have in memory.
enum RowValues<'a> {
    Doubles(&'a [f64]),
    Singles(&'a [f32]),
}

/// The numbers of all rows in the type they have in memory.
pub(crate) enum AllValues<'a> {
    Doubles(&'a [f64]),
    Singles(&'a [f32]),
}

/// The numbers of all rows.
enum Values<'a> {
    /// In a type that is used as it is.
    Doubles(&'a [f64]),
    Singles(&'a [f32]),
    /// Converted once; null becomes NaN.
    Converted(Vec<f64>),
}

/// Scale of the numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Scale {
    /// In another unit, or, with the factor 1, in the wanted unit.
    Factor(f64),
    /// As levels in dB.
    Level,
}

impl Scale {
    fn of(self, number: f64) -> f64 {
        match self {
            Self::Factor(factor) => number * factor,
            // Minus infinity is not an amplitude of zero but a missing reading.
            Self::Level if !number.is_finite() => f64::NAN,
            Self::Level => 10f64.powf(number / 20.0),
        }
    }
}

impl<'a> Lists<'a> {
    fn new(name: &str, lists: &'a ArrayRef, scale: Scale) -> Result<Self, Error> {
        Self::converted_by(converted, lists, scale).ok_or_else(|| Error::ColumnType {
            name: name.to_owned(),
            found: lists.data_type().clone(),
            needed: NUMBERS,
        })
    }

    /// Lists whose values this function converts to doubles on their scale, if they are not doubles already.
    fn converted_by(convert: Convert, lists: &'a ArrayRef, scale: Scale) -> Option<Self> {
        let (places, values) = Places::new(lists)?;
        let values = match values.data_type() {
            _ if scale != Scale::Factor(1.0) => {
                let written = decoded(values, convert)?.into_iter();
                Values::Converted(written.map(|number| scale.of(number)).collect())
            }
            DataType::Float64 if values.null_count() == 0 => {
                Values::Doubles(values.as_primitive::<Float64Type>().values())
            }
            DataType::Float32 if values.null_count() == 0 => {
                Values::Singles(values.as_primitive::<Float32Type>().values())
            }
            _ => Values::Converted(decoded(values, convert)?),
        };
        Some(Self { places, values })
    }

    /// The numbers of all rows; [`place`](Self::place) gives the position of each row.
    pub(crate) fn all_values(&self) -> AllValues<'_> {
        match &self.values {
            Values::Doubles(values) => AllValues::Doubles(values),
            Values::Converted(values) => AllValues::Doubles(values),
            Values::Singles(values) => AllValues::Singles(values),
        }
    }

    /// Position of the numbers of a row; `None` if it is null.
    pub(crate) fn place(&self, row: usize) -> Option<Range<usize>> {
        self.places.of(row)
    }

    /// The numbers of a row without conversion; `None` if it is null.
    fn row_values(&self, row: usize) -> Option<RowValues<'_>> {
        let range = self.place(row)?;
        Some(match &self.values {
            Values::Doubles(values) => RowValues::Doubles(&values[range]),
            Values::Converted(values) => RowValues::Doubles(&values[range]),
            Values::Singles(values) => RowValues::Singles(&values[range]),
        })
    }

    /// The numbers of a row as doubles; `None` if it is null.
    pub(crate) fn get<'s>(&'s self, row: usize, scratch: &'s mut Vec<f64>) -> Option<&'s [f64]> {
        Some(match self.row_values(row)? {
            RowValues::Doubles(values) => values,
            RowValues::Singles(values) => {
                scratch.clear();
                scratch.extend(values.iter().map(|v| f64::from(*v)));
                scratch
            }
        })
    }

    pub(crate) fn rows(&self) -> usize {
        self.places.rows
    }
}

/// A list of times in each row.
enum Times<'a> {
    /// Seconds: numbers as they are, and durations.
    Seconds(Lists<'a>),
    /// Dates; each row counts from its first one.
    Dates { places: Places<'a>, stamps: &'a [i64], nulls: Option<&'a NullBuffer>, unit: TimeUnit },
}

impl<'a> Times<'a> {
    fn new(name: &str, lists: &'a ArrayRef, factor: f64) -> Result<Self, Error> {
        let dates = || {
            let (places, values) = Places::new(lists)?;
            let (stamps, unit) = stamps(values)?;
            Some(Self::Dates { places, stamps, nulls: values.nulls(), unit })
        };
        let numbers = || {
            let (_, values) = Places::new(lists)?;
            let scale = Scale::Factor(if is_duration(values) { 1.0 } else { factor });
            Lists::converted_by(seconds, lists, scale).map(Self::Seconds)
        };
        dates().or_else(numbers).ok_or_else(|| Error::ColumnType {
            name: name.to_owned(),
            found: lists.data_type().clone(),
            needed: TIMES,
        })
    }

    /// The times of a row in seconds; `None` if it is null.
    fn get<'s>(&'s self, row: usize, scratch: &'s mut Vec<f64>) -> Option<&'s [f64]> {
        let (places, stamps, nulls, unit) = match self {
            Self::Seconds(lists) => return lists.get(row, scratch),
            Self::Dates { places, stamps, nulls, unit } => (places, stamps, nulls, unit),
        };
        let range = places.of(row)?;
        let known = |at: usize| nulls.is_none_or(|nulls| nulls.is_valid(at));
        let first = range.clone().find(|at| known(*at)).map_or(0, |at| stamps[at]);
        // Counts are subtracted before conversion to doubles, which have too few digits for nanoseconds since
        // 1970.
        let time = |at: usize| (i128::from(stamps[at]) - i128::from(first)) as f64 / per_second(*unit);
        scratch.clear();
        scratch.extend(range.map(|at| if known(at) { time(at) } else { f64::NAN }));
        Some(scratch)
    }
}

/// A number in each row.
enum Numbers {
    Same(f64),
    Each(Float64Array),
}

impl Numbers {
    /// The numbers of a column.
    fn each(
        batch: &RecordBatch,
        name: &str,
        factor: f64,
        convert: Convert,
        needed: &'static str,
    ) -> Result<Self, Error> {
        let held = values(batch, name, needed)?;
        let mut values = decoded(held, convert).ok_or_else(|| Error::ColumnType {
            name: name.to_owned(),
            found: held.data_type().clone(),
            needed,
        })?;
        if factor != 1.0 && !is_duration(held) {
            values.iter_mut().for_each(|value| *value *= factor);
        }
        Ok(Self::Each(Float64Array::new(values.into(), held.logical_nulls())))
    }

    fn get(&self, row: usize) -> Option<f64> {
        match self {
            Self::Same(value) => Some(*value),
            Self::Each(values) => values.is_valid(row).then(|| values.value(row)),
        }
    }
}

/// Converts values to doubles, null to NaN; `None` if they have another type.
type Convert = fn(&ArrayRef) -> Option<Vec<f64>>;

fn doubles<T: ArrowPrimitiveType>(values: &ArrayRef, double: impl Fn(T::Native) -> f64) -> Vec<f64> {
    let held: &PrimitiveArray<T> = values.as_primitive::<T>();
    held.iter().map(|v| v.map_or(f64::NAN, &double)).collect()
}

/// Numbers of any type as doubles, null as NaN; `None` if they are not numbers.
fn converted(values: &ArrayRef) -> Option<Vec<f64>> {
    let scaled = |scale: i8| {
        let power = 10f64.powi(i32::from(scale.unsigned_abs()));
        // Powers of ten below one are not exact, those above are.
        move |v: f64| if scale < 0 { v * power } else { v / power }
    };
    Some(match values.data_type() {
        DataType::Float64 => doubles::<Float64Type>(values, |v| v),
        DataType::Float32 => doubles::<Float32Type>(values, f64::from),
        DataType::Float16 => doubles::<Float16Type>(values, f64::from),
        DataType::Int8 => doubles::<Int8Type>(values, f64::from),
        DataType::Int16 => doubles::<Int16Type>(values, f64::from),
        DataType::Int32 => doubles::<Int32Type>(values, f64::from),
        DataType::Int64 => doubles::<Int64Type>(values, |v| v as f64),
        DataType::UInt8 => doubles::<UInt8Type>(values, f64::from),
        DataType::UInt16 => doubles::<UInt16Type>(values, f64::from),
        DataType::UInt32 => doubles::<UInt32Type>(values, f64::from),
        DataType::UInt64 => doubles::<UInt64Type>(values, |v| v as f64),
        DataType::Decimal32(_, scale) => {
            let value = scaled(*scale);
            doubles::<Decimal32Type>(values, |v| value(f64::from(v)))
        }
        DataType::Decimal64(_, scale) => {
            let value = scaled(*scale);
            doubles::<Decimal64Type>(values, |v| value(v as f64))
        }
        DataType::Decimal128(_, scale) => {
            let value = scaled(*scale);
            doubles::<Decimal128Type>(values, |v| value(v as f64))
        }
        DataType::Decimal256(_, scale) => {
            let value = scaled(*scale);
            doubles::<Decimal256Type>(values, |v| value(wide(v)))
        }
        // A column that contains only nulls.
        DataType::Null => vec![f64::NAN; values.len()],
        _ => return None,
    })
}

/// A 256-bit integer as a double.
fn wide(value: i256) -> f64 {
    let (low, high) = value.to_parts();
    // In two parts, a small negative number would be the difference of two large ones.
    value.to_i128().map_or_else(|| high as f64 * 2f64.powi(128) + low as f64, |v| v as f64)
}

/// Whether the type of the values, plain or encoded, includes a unit of time.
fn is_duration(values: &ArrayRef) -> bool {
    matches!(plain(values.data_type()), DataType::Duration(_))
}

/// The type of the values of a column, whose encoding as a dictionary or in runs changes none of them.
pub fn plain(found: &DataType) -> &DataType {
    match found {
        DataType::Dictionary(_, values) => plain(values),
        DataType::RunEndEncoded(_, values) => plain(values.data_type()),
        other => other,
    }
}

/// [`converted`], with durations in seconds.
fn seconds(values: &ArrayRef) -> Option<Vec<f64>> {
    let DataType::Duration(unit) = values.data_type() else { return converted(values) };
    let second = |v: i64| v as f64 / per_second(*unit);
    Some(match unit {
        TimeUnit::Second => doubles::<DurationSecondType>(values, second),
        TimeUnit::Millisecond => doubles::<DurationMillisecondType>(values, second),
        TimeUnit::Microsecond => doubles::<DurationMicrosecondType>(values, second),
        TimeUnit::Nanosecond => doubles::<DurationNanosecondType>(values, second),
    })
}

/// Dates as counts of their unit; `None` if they are not dates.
fn stamps(values: &ArrayRef) -> Option<(&[i64], TimeUnit)> {
    let DataType::Timestamp(unit, _) = values.data_type() else { return None };
    let counts = match unit {
        TimeUnit::Second => values.as_primitive::<TimestampSecondType>().values(),
        TimeUnit::Millisecond => values.as_primitive::<TimestampMillisecondType>().values(),
        TimeUnit::Microsecond => values.as_primitive::<TimestampMicrosecondType>().values(),
        TimeUnit::Nanosecond => values.as_primitive::<TimestampNanosecondType>().values(),
    };
    Some((counts, *unit))
}

fn per_second(unit: TimeUnit) -> f64 {
    match unit {
        TimeUnit::Second => 1.0,
        TimeUnit::Millisecond => 1e3,
        TimeUnit::Microsecond => 1e6,
        TimeUnit::Nanosecond => 1e9,
    }
}
