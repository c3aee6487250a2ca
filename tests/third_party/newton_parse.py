"""Run in an environment with newton: what its ModelBuilder makes of USD files.

Arguments: a JSON file with a list of paths (an empty list: the USD files of newton's own package), the file to write.
"""

import json
import sys
from pathlib import Path

import newton
import warp as wp


def parse(path):
    """Bodies with masses, joints with type and degrees of freedom; or why newton does not parse the file."""
    builder = newton.ModelBuilder()
    builder.add_usd(str(path), load_visual_shapes=False, skip_mesh_approximation=True)
    dof_starts = [*builder.joint_qd_start, builder.joint_dof_count]
    return {
        "bodies": dict(zip(builder.body_label, builder.body_mass, strict=True)),
        "joints": [
            {
                "path": builder.joint_label[i],
                "type": newton.JointType(builder.joint_type[i]).name,
                "dofs": dof_starts[i + 1] - dof_starts[i],
                "parent": builder.joint_parent[i],
                "child": builder.body_label[builder.joint_child[i]],
                "articulation": builder.joint_articulation[i],
            }
            for i in range(builder.joint_count)
        ],
    }


def main():
    asked, answered = sys.argv[1:]
    wp.config.quiet = True
    files = json.loads(Path(asked).read_text())
    package = Path(newton.__file__).parent
    if not files:
        files = sorted(str(p) for p in package.rglob("*") if p.suffix in (".usd", ".usda", ".usdc", ".usdz"))
    results = {}
    for path in files:
        try:
            results[path] = parse(path)
        except Exception as error:  # whatever newton raises is the answer
            results[path] = {"error": f"{type(error).__name__}: {error}"}
    Path(answered).write_text(json.dumps({"package": str(package), "files": results}))


if __name__ == "__main__":
    main()
