//! Compiles kernels for an AMD GPU that need not be there, and compares registers and occupancy with a stored table
//! (`scripts/check_shapes.sh`).

mod driver;

use std::{error::Error, fs, path::PathBuf, process::ExitCode};

use clap::Parser;

use driver::Driver;

/// Columns of the table, by the driver's names of them.
const COLUMNS: [(&str, &str); 6] = [
    ("registers", "VGPRs"),
    ("spilled", "Spilled VGPRs"),
    ("workgroup bytes", "LDS size"),
    ("scratch bytes", "Scratch size"),
    ("waves", "Subgroups per SIMD"),
    ("code bytes", "Code size"),
];
const SCRATCH: usize = 3;
const WAVES: usize = 4;

#[derive(Parser)]
struct Arguments {
    /// Table to compare with.
    table: PathBuf,
    /// WGSL modules with one entry point each.
    #[arg(required = true)]
    modules: Vec<PathBuf>,
    /// Write the table.
    #[arg(long)]
    write: bool,
}

/// A module's name, and its numbers in the order of [`COLUMNS`].
type Row = (String, Vec<u64>);

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let arguments = Arguments::parse();
    let driver = Driver::new()?;
    println!("compiled by {}", driver.name);
    let rows = arguments.modules.iter().map(|path| row(&driver, path)).collect::<Result<Vec<Row>, _>>()?;
    let head = format!("{}\t{}", driver.name, COLUMNS.map(|(name, _)| name).join("\t"));
    if arguments.write {
        let lines = rows.iter().map(|(name, numbers)| format!("{name}\t{}\n", tabbed(numbers)));
        fs::write(&arguments.table, format!("{head}\n{}", lines.collect::<String>()))?;
        println!("wrote {} modules to {}", rows.len(), arguments.table.display());
        return Ok(ExitCode::SUCCESS);
    }
    let stored = fs::read_to_string(&arguments.table)?;
    let mut lines = stored.lines();
    if lines.next() != Some(&head) {
        println!("{} is by another driver: nothing is compared", arguments.table.display());
        return Ok(ExitCode::SUCCESS);
    }
    let stored = lines.map(parsed).collect::<Result<Vec<Row>, _>>()?;
    Ok(if is_no_worse(&rows, &stored) { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn row(driver: &Driver, path: &PathBuf) -> Result<Row, Box<dyn Error>> {
    let of = |error: Box<dyn Error>| format!("{}: {error}", path.display());
    let found = driver.compile(&fs::read_to_string(path)?).map_err(of)?;
    let number = |(_, key): (&str, &str)| found.get(key).copied().ok_or_else(|| format!("the driver has no '{key}'"));
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    Ok((name, COLUMNS.into_iter().map(number).collect::<Result<_, _>>()?))
}

fn tabbed(numbers: &[u64]) -> String {
    numbers.iter().map(u64::to_string).collect::<Vec<_>>().join("\t")
}

fn parsed(line: &str) -> Result<Row, Box<dyn Error>> {
    let mut cells = line.split('\t');
    let name = cells.next().unwrap_or_default().to_owned();
    Ok((name, cells.map(str::parse).collect::<Result<_, _>>()?))
}

/// Prints what changed. Returns whether no module has more scratch or fewer waves, and the modules are the same.
fn is_no_worse(rows: &[Row], stored: &[Row]) -> bool {
    let mut worse = 0;
    for (name, now) in rows {
        let Some((_, before)) = stored.iter().find(|(stored, _)| stored == name) else {
            println!("{name}: not in the table");
            worse += 1;
            continue;
        };
        let is_worse = now[SCRATCH] > before[SCRATCH] || now[WAVES] < before[WAVES];
        worse += usize::from(is_worse);
        if is_worse || now[WAVES] > before[WAVES] || now[SCRATCH] < before[SCRATCH] {
            let how = if is_worse { "worse" } else { "better" };
            println!("{name}: {how}");
            for ((column, _), (before, now)) in COLUMNS.iter().zip(before.iter().zip(now)) {
                println!("    {column}: {before} -> {now}");
            }
        }
    }
    for (name, _) in stored.iter().filter(|(name, _)| rows.iter().all(|(now, _)| now != name)) {
        println!("{name}: in the table, but not compiled");
        worse += 1;
    }
    println!("{} modules: {worse} worse than the table, or not in both", rows.len());
    worse == 0
}
