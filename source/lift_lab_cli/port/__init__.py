"""Port a package of Isaac Lab 2.x: rename its imports and list what lift_lab does not support.

lift-lab port FOLDER --out DIR
lift-lab port FOLDER --in_place

Without --out and --in_place nothing is written, and the report says what would change. No file of the folder is run.
docs/porting.md says how to run the result.
"""

from __future__ import annotations

from pathlib import Path

from lift_lab.app import cli


def main() -> int:
    parser = cli.Parser(__doc__, overrides=False)
    parser.add_argument("folder", type=Path, metavar="FOLDER", help="a package or repository for Isaac Lab 2.x")
    parser.add_argument("--out", type=Path, default=None, metavar="DIR", help="a new folder for the ported files")
    parser.add_argument("--in_place", action="store_true", help="change the files of FOLDER themselves")
    args, _ = parser.parse()
    if args.out is not None and args.in_place:
        parser.error("--out and --in_place both say where the result goes: give one")

    from .package import Package, check_out

    if args.out is not None:
        check_out(args.folder, args.out)
    package = Package(args.folder)
    unsupported = package.unsupported()
    if args.out is not None:
        package.write(args.out)
    elif args.in_place:
        package.write_in_place()
    place = args.out or args.folder

    renamed = [source.renamed for source in package.sources.values() if source.renamed]
    print(f"Python files: {len(package.sources)}, of which {len(renamed)} change; names renamed: {sum(renamed)}")
    print(f"other files, unchanged: {len(package.others)}")
    for path, source in package.sources.items():
        if source.problem is not None:
            print(f"not parsed, unchanged: {place / path}: {source.problem}")
    for path, kind in package.left_out.items():
        print(f"{kind}, left out: {package.folder / path}")
    for remark in package.mentions():
        print(f"change by hand: {place / remark.file}:{remark.line}: {remark.text}")
    print(f"names that lift_lab does not support: {len(unsupported)}")
    for remark in unsupported:
        print(f"  {place / remark.file}:{remark.line}: {remark.text}")
    print(f"written: {place}" if args.out or args.in_place else "nothing written: --out DIR writes the ported files")
    return 0


if __name__ == "__main__":
    cli.run(main)
