# Made by scripts/maintainers/make_stubs.py from mujoco 4.0.0. Do not edit.
import collections.abc
import typing
from typing import Any, ClassVar

import numpy
import numpy.typing
from numpy.typing import NDArray
import mujoco._enums
import mujoco._structs

from ._types import *

class MjCharVec:
    def __getitem__(self, arg0: Whole) -> str: ...
    def __init__(self, arg0: str, arg1: Whole) -> None: ...
    def __iter__(self) -> collections.abc.Iterator[str]: ...
    def __len__(self) -> int: ...
    def __setitem__(self, arg0: Whole, arg1: str) -> None: ...

class MjDoubleVec:
    def __getitem__(self, arg0: Whole) -> float: ...
    def __init__(self, arg0: Real, arg1: Whole) -> None: ...
    def __iter__(self) -> collections.abc.Iterator[float]: ...
    def __len__(self) -> int: ...
    def __setitem__(self, arg0: Whole, arg1: Real) -> None: ...

class MjFloatVec:
    def __getitem__(self, arg0: Whole) -> float: ...
    def __init__(self, arg0: Real, arg1: Whole) -> None: ...
    def __iter__(self) -> collections.abc.Iterator[float]: ...
    def __len__(self) -> int: ...
    def __setitem__(self, arg0: Whole, arg1: Real) -> None: ...

class MjIntVec:
    def __getitem__(self, arg0: Whole) -> int: ...
    def __init__(self, arg0: Whole, arg1: Whole) -> None: ...
    def __iter__(self) -> collections.abc.Iterator[int]: ...
    def __len__(self) -> int: ...
    def __setitem__(self, arg0: Whole, arg1: Whole) -> None: ...

class MjOption:
    ccd_iterations: Field[int, Whole]
    ccd_tolerance: Field[float, Real]
    cone: Field[int, Whole]
    density: Field[float, Real]
    disableactuator: Field[int, Whole]
    disableflags: Field[int, Whole]
    enableflags: Field[int, Whole]
    gravity: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    impratio: Field[float, Real]
    integrator: Field[int, Whole]
    iterations: Field[int, Whole]
    jacobian: Field[int, Whole]
    ls_iterations: Field[int, Whole]
    ls_tolerance: Field[float, Real]
    magnetic: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    noslip_iterations: Field[int, Whole]
    noslip_tolerance: Field[float, Real]
    o_friction: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    o_margin: Field[float, Real]
    o_solimp: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    o_solref: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    sdf_initpoints: Field[int, Whole]
    sdf_iterations: Field[int, Whole]
    sleep_tolerance: Field[float, Real]
    solver: Field[int, Whole]
    timestep: Field[float, Real]
    tolerance: Field[float, Real]
    viscosity: Field[float, Real]
    wind: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]

class MjSpec:
    def __init__(self) -> None: ...
    _address: Fixed[int]
    def activate_plugin(self, name: str) -> None: ...
    def actuator(self, arg0: str) -> MjsActuator: ...
    actuators: Fixed[list[MjsActuator]]
    def add_actuator(self, default: MjsDefault | None=..., name: str | None=..., type: Whole | None=..., gaintype: Whole | None=..., gainprm: Reals | None=..., biastype: Whole | None=..., biasprm: Reals | None=..., dyntype: Whole | None=..., dynprm: Reals | None=..., actdim: Whole | None=..., ctrlspec: Whole | None=..., velrange: Reals | None=..., ffrange: Reals | None=..., actearly: Whole | None=..., trntype: Whole | None=..., gear: Reals | None=..., target: str | None=..., refsite: str | None=..., slidersite: str | None=..., cranklength: Real | None=..., lengthrange: Reals | None=..., inheritrange: Real | None=..., damping: Any | None=..., armature: Real | None=..., ctrllimited: Whole | None=..., ctrlrange: Reals | None=..., forcelimited: Whole | None=..., forcerange: Reals | None=..., actlimited: Whole | None=..., actrange: Reals | None=..., group: Whole | None=..., nsample: Whole | None=..., interp: Whole | None=..., delay: Real | None=..., userdata: Reals | None=..., plugin: MjsPlugin | None=..., info: str | None=...) -> MjsActuator: ...
    def add_default(self, arg0: str, arg1: MjsDefault) -> MjsDefault: ...
    def add_equality(self, default: MjsDefault | None=..., name: str | None=..., type: Whole | None=..., data: Reals | None=..., active: Whole | None=..., name1: str | None=..., name2: str | None=..., objtype: Whole | None=..., solref: Reals | None=..., solimp: Reals | None=..., info: str | None=...) -> MjsEquality: ...
    def add_exclude(self, name: str | None=..., bodyname1: str | None=..., bodyname2: str | None=..., info: str | None=...) -> MjsExclude: ...
    def add_flex(self, name: str | None=..., contype: Whole | None=..., conaffinity: Whole | None=..., condim: Whole | None=..., priority: Whole | None=..., friction: Reals | None=..., solmix: Real | None=..., solref: Reals | None=..., solimp: Reals | None=..., margin: Real | None=..., gap: Real | None=..., dim: Whole | None=..., radius: Real | None=..., size: Any | None=..., flatskin: Whole | None=..., selfcollide: Whole | None=..., passive: Whole | None=..., activelayers: Whole | None=..., group: Whole | None=..., edgestiffness: Real | None=..., edgedamping: Real | None=..., rgba: Reals | None=..., material: collections.abc.Sequence[str] | None=..., young: Real | None=..., poisson: Real | None=..., shear: Real | None=..., damping: Real | None=..., thickness: Real | None=..., stressyield: Reals | None=..., elastic2d: Whole | None=..., elastic3d: Whole | None=..., section: Whole | None=..., sectionsize: Reals | None=..., cellcount: Reals | None=..., order: Whole | None=..., nodebody: collections.abc.Sequence[str] | None=..., vertbody: collections.abc.Sequence[str] | None=..., node: Reals | None=..., vert: Reals | None=..., elem: Wholes | None=..., texcoord: Reals | None=..., elemtexcoord: Wholes | None=..., info: str | None=...) -> MjsFlex: ...
    def add_hfield(self, name: str | None=..., content_type: str | None=..., file: str | None=..., size: Reals | None=..., nrow: Whole | None=..., ncol: Whole | None=..., userdata: Reals | None=..., info: str | None=...) -> MjsHField: ...
    def add_key(self, name: str | None=..., time: Real | None=..., qpos: Reals | None=..., qvel: Reals | None=..., act: Reals | None=..., mpos: Reals | None=..., mquat: Reals | None=..., ctrl: Reals | None=..., plastic: Reals | None=..., info: str | None=...) -> MjsKey: ...
    def add_material(self, default: MjsDefault | None=..., name: str | None=..., textures: collections.abc.Sequence[str] | None=..., texuniform: Whole | None=..., texrepeat: Reals | None=..., emission: Real | None=..., specular: Real | None=..., shininess: Real | None=..., reflectance: Real | None=..., metallic: Real | None=..., roughness: Real | None=..., rgba: Reals | None=..., info: str | None=...) -> MjsMaterial: ...
    def add_mesh(self, default: MjsDefault | None=..., name: str | None=..., content_type: str | None=..., file: str | None=..., refpos: Reals | None=..., refquat: Reals | None=..., scale: Reals | None=..., inertia: Whole | None=..., smoothnormal: Whole | None=..., needsdf: Whole | None=..., maxhullvert: Whole | None=..., uservert: Reals | None=..., usernormal: Reals | None=..., usertexcoord: Reals | None=..., userface: Wholes | None=..., userfacenormal: Wholes | None=..., userfacetexcoord: Wholes | None=..., usernode: Reals | None=..., usertet: Wholes | None=..., plugin: MjsPlugin | None=..., material: str | None=..., octree_maxdepth: Whole | None=..., info: str | None=...) -> MjsMesh: ...
    def add_numeric(self, name: str | None=..., data: Reals | None=..., size: Whole | None=..., info: str | None=...) -> MjsNumeric: ...
    def add_pair(self, default: MjsDefault | None=..., name: str | None=..., geomname1: str | None=..., geomname2: str | None=..., condim: Whole | None=..., solref: Reals | None=..., solreffriction: Reals | None=..., solimp: Reals | None=..., margin: Real | None=..., gap: Real | None=..., adhesion: Real | None=..., friction: Reals | None=..., info: str | None=...) -> MjsPair: ...
    def add_plugin(self, name: str | None=..., plugin_name: str | None=..., active: Whole | None=..., info: str | None=...) -> MjsPlugin: ...
    def add_sensor(self, name: str | None=..., type: Whole | None=..., objtype: Whole | None=..., objname: str | None=..., reftype: Whole | None=..., refname: str | None=..., intprm: Reals | None=..., datatype: Whole | None=..., needstage: Whole | None=..., dim: Whole | None=..., cutoff: Real | None=..., noise: Real | None=..., nsample: Whole | None=..., interp: Whole | None=..., delay: Real | None=..., interval: Reals | None=..., userdata: Reals | None=..., plugin: MjsPlugin | None=..., info: str | None=...) -> MjsSensor: ...
    def add_skin(self, name: str | None=..., file: str | None=..., material: str | None=..., rgba: Reals | None=..., inflate: Real | None=..., group: Whole | None=..., vert: Reals | None=..., texcoord: Reals | None=..., face: Wholes | None=..., bodyname: collections.abc.Sequence[str] | None=..., bindpos: Reals | None=..., bindquat: Reals | None=..., vertid: collections.abc.Sequence[Wholes] | None=..., vertweight: collections.abc.Sequence[Reals] | None=..., info: str | None=...) -> MjsSkin: ...
    def add_tendon(self, default: MjsDefault | None=..., name: str | None=..., stiffness: Any | None=..., springlength: Reals | None=..., springyield: Real | None=..., damping: Any | None=..., frictionloss: Real | None=..., solref_friction: Reals | None=..., solimp_friction: Reals | None=..., armature: Real | None=..., limited: Whole | None=..., actfrclimited: Whole | None=..., range: Reals | None=..., actfrcrange: Reals | None=..., margin: Real | None=..., solref_limit: Reals | None=..., solimp_limit: Reals | None=..., material: str | None=..., width: Real | None=..., rgba: Reals | None=..., group: Whole | None=..., userdata: Reals | None=..., info: str | None=...) -> MjsTendon: ...
    def add_text(self, name: str | None=..., data: str | None=..., info: str | None=...) -> MjsText: ...
    def add_texture(self, default: MjsDefault | None=..., name: str | None=..., type: Whole | None=..., colorspace: Whole | None=..., builtin: Whole | None=..., mark: Whole | None=..., rgb1: Reals | None=..., rgb2: Reals | None=..., markrgb: Reals | None=..., random: Real | None=..., height: Whole | None=..., width: Whole | None=..., nchannel: Whole | None=..., content_type: str | None=..., file: str | None=..., gridsize: Reals | None=..., gridlayout: Any | None=..., cubefiles: collections.abc.Sequence[str] | None=..., data: Wholes | None=..., hflip: Whole | None=..., vflip: Whole | None=..., embed: Whole | None=..., info: str | None=...) -> MjsTexture: ...
    def add_tuple(self, name: str | None=..., objtype: Wholes | None=..., objname: collections.abc.Sequence[str] | None=..., objprm: Reals | None=..., info: str | None=...) -> MjsTuple: ...
    def adopt_inertial(self, body: MjsBody, vfs: MjVfs | None=...) -> None: ...
    assets: dict
    def attach(self, child: MjSpec, prefix: str | None=..., suffix: str | None=..., site: Any | None=..., frame: Any | None=...) -> MjsFrame: ...
    authored: MjsAuthored
    bodies: Fixed[list[MjsBody]]
    def body(self, arg0: str) -> MjsBody: ...
    def camera(self, arg0: str) -> MjsCamera: ...
    cameras: Fixed[list[MjsCamera]]
    comment: str
    def compile(self, vfs: MjVfs | None=...) -> mujoco._structs.MjModel: ...
    compiler: MjsCompiler
    def copy(self) -> MjSpec: ...
    def copy_back(self, model: Any) -> None: ...
    copy_during_attach: Field[None, Any]
    def dedup_assets(self) -> int: ...
    default: Fixed[MjsDefault]
    @typing.overload
    def delete(self, arg0: MjsDefault) -> None: ...
    @typing.overload
    def delete(self, arg0: MjsBody) -> None: ...
    @typing.overload
    def delete(self, arg0: MjsFrame) -> None: ...
    @typing.overload
    def delete(self, arg0: MjsGeom) -> None: ...
    @typing.overload
    def delete(self, arg0: MjsJoint) -> None: ...
    @typing.overload
    def delete(self, arg0: MjsSite) -> None: ...
    @typing.overload
    def delete(self, arg0: MjsCamera) -> None: ...
    @typing.overload
    def delete(self, arg0: MjsLight) -> None: ...
    @typing.overload
    def delete(self, arg0: MjsMaterial) -> None: ...
    @typing.overload
    def delete(self, arg0: MjsMesh) -> None: ...
    @typing.overload
    def delete(self, arg0: MjsPair) -> None: ...
    @typing.overload
    def delete(self, arg0: MjsEquality) -> None: ...
    @typing.overload
    def delete(self, arg0: MjsActuator) -> None: ...
    @typing.overload
    def delete(self, arg0: MjsTendon) -> None: ...
    @typing.overload
    def delete(self, arg0: MjsSensor) -> None: ...
    @typing.overload
    def delete(self, arg0: MjsFlex) -> None: ...
    @typing.overload
    def delete(self, arg0: MjsHField) -> None: ...
    @typing.overload
    def delete(self, arg0: MjsSkin) -> None: ...
    @typing.overload
    def delete(self, arg0: MjsTexture) -> None: ...
    @typing.overload
    def delete(self, arg0: MjsKey) -> None: ...
    @typing.overload
    def delete(self, arg0: MjsText) -> None: ...
    @typing.overload
    def delete(self, arg0: MjsNumeric) -> None: ...
    @typing.overload
    def delete(self, arg0: MjsExclude) -> None: ...
    @typing.overload
    def delete(self, arg0: MjsTuple) -> None: ...
    @typing.overload
    def delete(self, arg0: MjsPlugin) -> None: ...
    def discard_visual(self, vfs: MjVfs | None=...) -> int: ...
    def encode(self, filename: str, model: Any | None=..., content_type: str | None=...) -> int: ...
    equalities: Fixed[list[MjsEquality]]
    def equality(self, arg0: str) -> MjsEquality: ...
    def exclude(self, arg0: str) -> MjsExclude: ...
    excludes: Fixed[list[MjsExclude]]
    def find_default(self, arg0: str) -> MjsDefault: ...
    def flex(self, arg0: str) -> MjsFlex: ...
    flexes: Fixed[list[MjsFlex]]
    def frame(self, arg0: str) -> MjsFrame: ...
    frames: Fixed[list[MjsFrame]]
    @staticmethod
    def from_file(filename: str, include: collections.abc.Mapping[str, bytes] | None=..., assets: dict | None=..., vfs: MjVfs | None=...) -> MjSpec: ...
    @staticmethod
    def from_string(xml: str, include: collections.abc.Mapping[str, bytes] | None=..., assets: dict | None=..., vfs: MjVfs | None=...) -> MjSpec: ...
    def from_zip(self, *args: Any, **kwargs: Any) -> Any: ...
    def fuse_static(self, vfs: MjVfs | None=...) -> int: ...
    def geom(self, arg0: str) -> MjsGeom: ...
    geoms: Fixed[list[MjsGeom]]
    hasImplicitPluginElem: bool
    def hfield(self, arg0: str) -> MjsHField: ...
    hfields: Fixed[list[MjsHField]]
    def joint(self, arg0: str) -> MjsJoint: ...
    joints: Fixed[list[MjsJoint]]
    def key(self, arg0: str) -> MjsKey: ...
    keys: Fixed[list[MjsKey]]
    def light(self, arg0: str) -> MjsLight: ...
    lights: Fixed[list[MjsLight]]
    def material(self, arg0: str) -> MjsMaterial: ...
    materials: Fixed[list[MjsMaterial]]
    memory: Field[int, Whole]
    def mesh(self, arg0: str) -> MjsMesh: ...
    meshdir: str
    meshes: Fixed[list[MjsMesh]]
    modelfiledir: str
    modelname: str
    nconmax: Field[int, Whole]
    nemax: Field[int, Whole]
    njmax: Field[int, Whole]
    nkey: Field[int, Whole]
    nstack: Field[int, Whole]
    def numeric(self, arg0: str) -> MjsNumeric: ...
    numerics: Fixed[list[MjsNumeric]]
    nuser_actuator: Field[int, Whole]
    nuser_body: Field[int, Whole]
    nuser_cam: Field[int, Whole]
    nuser_geom: Field[int, Whole]
    nuser_jnt: Field[int, Whole]
    nuser_sensor: Field[int, Whole]
    nuser_site: Field[int, Whole]
    nuser_tendon: Field[int, Whole]
    nuserdata: Field[int, Whole]
    option: MjOption
    override_assets: bool
    def pair(self, arg0: str) -> MjsPair: ...
    pairs: Fixed[list[MjsPair]]
    parent: Fixed[MjSpec]
    def plugin(self, arg0: str) -> MjsPlugin: ...
    plugins: Fixed[list[MjsPlugin]]
    def recompile(self, m: Any, d: Any, vfs: MjVfs | None=...) -> Any: ...
    @staticmethod
    def resolve_orientation(*args: Any, **kwargs: Any) -> Any: ...
    def sensor(self, arg0: str) -> MjsSensor: ...
    sensors: Fixed[list[MjsSensor]]
    def site(self, arg0: str) -> MjsSite: ...
    sites: Fixed[list[MjsSite]]
    def skin(self, arg0: str) -> MjsSkin: ...
    skins: Fixed[list[MjsSkin]]
    stat: MjStatistic
    strippath: bool
    def tendon(self, arg0: str) -> MjsTendon: ...
    tendons: Fixed[list[MjsTendon]]
    def text(self, arg0: str) -> MjsText: ...
    texts: Fixed[list[MjsText]]
    def texture(self, arg0: str) -> MjsTexture: ...
    texturedir: str
    textures: Fixed[list[MjsTexture]]
    timer: Fixed[NDArray[numpy.float64]]
    def to_file(self, arg0: str) -> None: ...
    def to_xml(self) -> str: ...
    def to_zip(self, *args: Any, **kwargs: Any) -> Any: ...
    def tuple(self, arg0: str) -> MjsTuple: ...
    tuples: Fixed[list[MjsTuple]]
    visual: MjVisual
    worldbody: Fixed[MjsBody]

class MjStatistic:
    center: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    extent: Field[float, Real]
    meaninertia: Field[float, Real]
    meanmass: Field[float, Real]
    meansize: Field[float, Real]

class MjStringVec:
    def __getitem__(self, arg0: Whole) -> str: ...
    def __init__(self, arg0: str, arg1: Whole) -> None: ...
    def __iter__(self) -> collections.abc.Iterator[str]: ...
    def __len__(self) -> int: ...
    def __setitem__(self, arg0: Whole, arg1: str) -> None: ...

class MjVfs:
    def __contains__(self, arg0: str) -> bool: ...
    def __init__(self) -> None: ...
    def __setitem__(self, arg0: str, arg1: bytes) -> None: ...
    def close(self) -> None: ...

class MjVisual:
    global_: mujoco._structs.MjVisual.Global
    headlight: MjVisualHeadlight
    map: mujoco._structs.MjVisual.Map
    quality: mujoco._structs.MjVisual.Quality
    rgba: MjVisualRgba
    scale: mujoco._structs.MjVisual.Scale

class MjVisualHeadlight:
    active: Field[int, Whole]
    ambient: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    diffuse: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    specular: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]

class MjVisualRgba:
    actuator: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    actuatornegative: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    actuatorpositive: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    bv: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    bvactive: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    camera: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    com: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    connect: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    constraint: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    contactforce: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    contactfriction: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    contactgap: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    contactpoint: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    contacttorque: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    crankbroken: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    fog: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    force: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    frustum: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    haze: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    inertia: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    joint: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    light: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    rangefinder: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    selectpoint: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    slidercrank: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]

class MjsActuator:
    actdim: Field[int, Whole]
    actearly: bool
    actlimited: Field[mujoco._enums.mjtLimited, Whole]
    actrange: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    armature: Field[float, Real]
    biasprm: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    biastype: Field[mujoco._enums.mjtBias, Whole]
    classname: MjsDefault
    compiler: Fixed[MjsCompiler]
    cranklength: Field[float, Real]
    ctrllimited: Field[mujoco._enums.mjtLimited, Whole]
    ctrlrange: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    ctrlspec: Field[int, Whole]
    damping: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    delay: Field[float, Real]
    dynprm: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    dyntype: Field[mujoco._enums.mjtDyn, Whole]
    ffrange: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    forcelimited: Field[mujoco._enums.mjtLimited, Whole]
    forcerange: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    gainprm: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    gaintype: Field[mujoco._enums.mjtGain, Whole]
    gear: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    group: Field[int, Whole]
    id: Fixed[int]
    info: str
    inheritrange: Field[float, Real]
    interp: Field[int, Whole]
    lengthrange: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    name: str
    nsample: Field[int, Whole]
    plugin: MjsPlugin
    refsite: str
    def set_to_adhesion(self, gain: Real) -> None: ...
    def set_to_cylinder(self, timeconst: Real, bias: Real, area: Real, diameter: Real=...) -> None: ...
    def set_to_damper(self, kv: Real) -> None: ...
    def set_to_dcmotor(self, motorconst: Reals, resistance: Real, nominal: Reals=..., saturation: Reals=..., inductance: Reals=..., cogging: Reals=..., controller: Reals=..., thermal: Reals=..., lugre: Reals=..., ctrlspec: Whole=...) -> None: ...
    def set_to_intvelocity(self, kp: Real, kv: Real=..., dampratio: Real=..., timeconst: Real=..., inheritrange: bool=...) -> None: ...
    def set_to_motor(self) -> None: ...
    def set_to_muscle(self, *args: Any, **kwargs: Any) -> Any: ...
    def set_to_orientation(self, kp: Real, kv: Real=..., dampratio: Real=..., ctrlspec: Whole=...) -> None: ...
    def set_to_pid(self, kp: Real, kv: Real=..., dampratio: Real=..., ki: Real=..., imax: Real=..., slewmax: Real=..., inheritrange: Real=..., ctrlspec: Whole=...) -> None: ...
    def set_to_position(self, kp: Real, kv: Real=..., dampratio: Real=..., timeconst: Real=..., inheritrange: bool=...) -> None: ...
    def set_to_velocity(self, kv: Real) -> None: ...
    signature: Fixed[int]
    slidersite: str
    target: str
    trntype: Field[mujoco._enums.mjtTrn, Whole]
    type: Field[mujoco._enums.mjtActuator, Whole]
    userdata: Field[MjDoubleVec, Any]
    velrange: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]

class MjsAuthored:
    disableactuator: Field[int, Whole]
    disableflags: Field[int, Whole]
    enableflags: Field[int, Whole]
    option: Field[int, Whole]
    visual_global: Field[int, Whole]
    visual_headlight: Field[int, Whole]
    visual_map: Field[int, Whole]
    visual_quality: Field[int, Whole]
    visual_rgba: Field[int, Whole]
    visual_scale: Field[int, Whole]

class MjsBody:
    def add_body(self, default: MjsDefault | None=..., name: str | None=..., childclass: str | None=..., pos: Reals | None=..., quat: Reals | None=..., axisangle: Reals | None=..., xyaxes: Reals | None=..., zaxis: Reals | None=..., euler: Reals | None=..., mass: Real | None=..., ipos: Reals | None=..., iquat: Reals | None=..., inertia: Reals | None=..., iaxisangle: Reals | None=..., ixyaxes: Reals | None=..., izaxis: Reals | None=..., ieuler: Reals | None=..., fullinertia: Reals | None=..., mocap: Whole | None=..., gravcomp: Real | None=..., sleep: Whole | None=..., simple: Whole | None=..., fuse: Whole | None=..., userdata: Reals | None=..., explicitinertial: Whole | None=..., plugin: MjsPlugin | None=..., info: str | None=...) -> MjsBody: ...
    def add_camera(self, default: MjsDefault | None=..., name: str | None=..., pos: Reals | None=..., quat: Reals | None=..., axisangle: Reals | None=..., xyaxes: Reals | None=..., zaxis: Reals | None=..., euler: Reals | None=..., mode: Whole | None=..., targetbody: str | None=..., proj: Whole | None=..., resolution: Reals | None=..., output: Whole | None=..., fovy: Real | None=..., ipd: Real | None=..., intrinsic: Reals | None=..., sensor_size: Reals | None=..., focal_length: Reals | None=..., focal_pixel: Reals | None=..., principal_length: Reals | None=..., principal_pixel: Reals | None=..., userdata: Reals | None=..., info: str | None=...) -> MjsCamera: ...
    def add_frame(self, default: MjsFrame | None=..., name: str | None=..., childclass: str | None=..., pos: Reals | None=..., quat: Reals | None=..., axisangle: Reals | None=..., xyaxes: Reals | None=..., zaxis: Reals | None=..., euler: Reals | None=..., scale: Any | None=..., scaling: Whole | None=..., massscale: Real | None=..., info: str | None=...) -> MjsFrame: ...
    def add_freejoint(self, **kwargs) -> MjsJoint: ...
    def add_geom(self, default: MjsDefault | None=..., name: str | None=..., type: Whole | None=..., pos: Reals | None=..., quat: Reals | None=..., axisangle: Reals | None=..., xyaxes: Reals | None=..., zaxis: Reals | None=..., euler: Reals | None=..., fromto: Reals | None=..., size: Any | None=..., contype: Whole | None=..., conaffinity: Whole | None=..., condim: Whole | None=..., priority: Whole | None=..., friction: Reals | None=..., solmix: Real | None=..., solref: Reals | None=..., solimp: Reals | None=..., margin: Real | None=..., gap: Real | None=..., surfacevel: Reals | None=..., adhesion: Real | None=..., mass: Real | None=..., density: Real | None=..., typeinertia: Whole | None=..., fluid_ellipsoid: Whole | None=..., fluid_coefs: Reals | None=..., material: str | None=..., rgba: Reals | None=..., group: Whole | None=..., castshadow: Whole | None=..., hfieldname: str | None=..., meshname: str | None=..., fitscale: Real | None=..., userdata: Reals | None=..., plugin: MjsPlugin | None=..., info: str | None=...) -> MjsGeom: ...
    def add_joint(self, default: MjsDefault | None=..., name: str | None=..., type: Whole | None=..., pos: Reals | None=..., axis: Reals | None=..., ref: Real | None=..., align: Whole | None=..., stiffness: Any | None=..., springref: Real | None=..., springyield: Real | None=..., springdamper: Reals | None=..., limited: Whole | None=..., range: Reals | None=..., margin: Real | None=..., solref_limit: Reals | None=..., solimp_limit: Reals | None=..., actfrclimited: Whole | None=..., actfrcrange: Reals | None=..., armature: Real | None=..., damping: Any | None=..., frictionloss: Real | None=..., solref_friction: Reals | None=..., solimp_friction: Reals | None=..., group: Whole | None=..., actgravcomp: Whole | None=..., userdata: Reals | None=..., info: str | None=...) -> MjsJoint: ...
    def add_light(self, default: MjsDefault | None=..., name: str | None=..., pos: Reals | None=..., dir: Reals | None=..., mode: Whole | None=..., targetbody: str | None=..., active: Whole | None=..., type: Whole | None=..., texture: str | None=..., castshadow: Whole | None=..., bulbradius: Real | None=..., intensity: Real | None=..., range: Real | None=..., attenuation: Reals | None=..., cutoff: Real | None=..., softness: Real | None=..., exponent: Real | None=..., ambient: Reals | None=..., diffuse: Reals | None=..., specular: Reals | None=..., info: str | None=...) -> MjsLight: ...
    def add_site(self, default: MjsDefault | None=..., name: str | None=..., pos: Reals | None=..., quat: Reals | None=..., axisangle: Reals | None=..., xyaxes: Reals | None=..., zaxis: Reals | None=..., euler: Reals | None=..., fromto: Reals | None=..., size: Any | None=..., type: Whole | None=..., material: str | None=..., group: Whole | None=..., rgba: Reals | None=..., meshname: str | None=..., userdata: Reals | None=..., info: str | None=...) -> MjsSite: ...
    alt: MjsOrientation
    def attach_frame(self, frame: MjsFrame, prefix: str | None=..., suffix: str | None=...) -> MjsFrame: ...
    bodies: Fixed[list[MjsBody]]
    cameras: Fixed[list[MjsCamera]]
    childclass: str
    classname: MjsDefault
    compiler: Fixed[MjsCompiler]
    explicitinertial: bool
    @typing.overload
    def find_all(self, arg0: mujoco._enums.mjtObj) -> list[Any]: ...
    @typing.overload
    def find_all(self, arg0: str) -> list[Any]: ...
    def find_child(self, arg0: str) -> MjsBody: ...
    def first_body(self) -> MjsBody: ...
    def first_camera(self) -> MjsCamera: ...
    def first_frame(self) -> MjsFrame: ...
    def first_geom(self) -> MjsGeom: ...
    def first_joint(self) -> MjsJoint: ...
    def first_light(self) -> MjsLight: ...
    def first_site(self) -> MjsSite: ...
    frame: Fixed[MjsFrame]
    frames: Fixed[list[MjsFrame]]
    fullinertia: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    fuse: Field[int, Whole]
    geoms: Fixed[list[MjsGeom]]
    gravcomp: Field[float, Real]
    ialt: MjsOrientation
    id: Fixed[int]
    inertia: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    info: str
    ipos: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    iquat: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    joints: Fixed[list[MjsJoint]]
    lights: Fixed[list[MjsLight]]
    def make_flex(self, name: str, type: str | None=..., dim: Whole=..., dof: str | None=..., count: Wholes | None=..., cellcount: Wholes | None=..., spacing: Reals | None=..., scale: Reals | None=..., radius: Real=..., mass: Real=..., inertiabox: Real=..., equality: Whole=..., rigid: Whole=..., flatskin: Whole=..., elastic2d: Whole=..., pos: Reals | None=..., quat: Reals | None=..., origin: Reals | None=..., file: str | None=..., mesh: str | None=..., vfs: MjVfs | None=...) -> MjsFlex: ...
    mass: Field[float, Real]
    mocap: bool
    name: str
    def next_body(self, arg0: MjsBody) -> MjsBody: ...
    def next_camera(self, arg0: MjsCamera) -> MjsCamera: ...
    def next_frame(self, arg0: MjsFrame) -> MjsFrame: ...
    def next_geom(self, arg0: MjsGeom) -> MjsGeom: ...
    def next_joint(self, arg0: MjsJoint) -> MjsJoint: ...
    def next_light(self, arg0: MjsLight) -> MjsLight: ...
    def next_site(self, arg0: MjsSite) -> MjsSite: ...
    parent: Fixed[MjsBody]
    plugin: MjsPlugin
    pos: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    quat: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    def set_frame(self, arg0: MjsFrame) -> None: ...
    signature: Fixed[int]
    simple: Field[int, Whole]
    sites: Fixed[list[MjsSite]]
    sleep: Field[mujoco._enums.mjtSleepPolicy, Whole]
    def to_frame(self) -> MjsFrame: ...
    userdata: Field[MjDoubleVec, Any]

class MjsCamera:
    alt: MjsOrientation
    classname: MjsDefault
    compiler: Fixed[MjsCompiler]
    focal_length: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    focal_pixel: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    fovy: Field[float, Real]
    frame: Fixed[MjsFrame]
    id: Fixed[int]
    info: str
    intrinsic: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    ipd: Field[float, Real]
    mode: Field[mujoco._enums.mjtCamLight, Whole]
    name: str
    output: Field[int, Whole]
    parent: Fixed[MjsBody]
    pos: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    principal_length: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    principal_pixel: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    proj: Field[mujoco._enums.mjtProjection, Whole]
    quat: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    resolution: Field[NDArray[numpy.int32], numpy.typing.ArrayLike]
    sensor_size: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    def set_frame(self, arg0: MjsFrame) -> None: ...
    signature: Fixed[int]
    targetbody: str
    userdata: Field[MjDoubleVec, Any]

class MjsCompiler:
    LRopt: mujoco._structs.MjLROpt
    alignfree: bool
    authored: Field[int, Whole]
    autolimits: bool
    balanceinertia: bool
    boundinertia: Field[float, Real]
    boundmass: Field[float, Real]
    conflict: Field[mujoco._enums.mjtConflict, Whole]
    degree: bool
    discardvisual: bool
    eulerseq: Field[MjCharVec, Any]
    fitaabb: bool
    fusestatic: bool
    inertiafromgeom: Field[mujoco._enums.mjtInertiaFromGeom, Whole]
    inertiagrouprange: Field[NDArray[numpy.int32], numpy.typing.ArrayLike]
    meshdir: str
    passthrough: Field[mujoco._enums.mjtPassthrough, Whole]
    savecanonical: bool
    savecompiled: bool
    saveinertial: bool
    settotalmass: Field[float, Real]
    texturedir: str
    usethread: bool

class MjsDefault:
    actuator: MjsActuator
    camera: MjsCamera
    equality: MjsEquality
    flex: MjsFlex
    geom: MjsGeom
    joint: MjsJoint
    light: MjsLight
    material: MjsMaterial
    mesh: MjsMesh
    name: str
    pair: MjsPair
    site: MjsSite
    tendon: MjsTendon
    texture: MjsTexture

class MjsEquality:
    active: bool
    classname: MjsDefault
    compiler: Fixed[MjsCompiler]
    data: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    id: Fixed[int]
    info: str
    name: str
    name1: str
    name2: str
    objtype: Field[mujoco._enums.mjtObj, Whole]
    signature: Fixed[int]
    solimp: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    solref: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    type: Field[mujoco._enums.mjtEq, Whole]

class MjsExclude:
    bodyname1: str
    bodyname2: str
    compiler: Fixed[MjsCompiler]
    id: Fixed[int]
    info: str
    name: str
    signature: Fixed[int]

class MjsFlex:
    activelayers: Field[int, Whole]
    cellcount: Field[NDArray[numpy.int32], numpy.typing.ArrayLike]
    compiler: Fixed[MjsCompiler]
    conaffinity: Field[int, Whole]
    condim: Field[int, Whole]
    contype: Field[int, Whole]
    damping: Field[float, Real]
    dim: Field[int, Whole]
    edgedamping: Field[float, Real]
    edgestiffness: Field[float, Real]
    elastic2d: Field[int, Whole]
    elastic3d: Field[int, Whole]
    elem: Field[MjIntVec, Any]
    elemtexcoord: Field[MjIntVec, Any]
    flatskin: bool
    friction: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    gap: Field[float, Real]
    group: Field[int, Whole]
    id: Fixed[int]
    info: str
    margin: Field[float, Real]
    material: Field[MjStringVec, Any]
    name: str
    node: Field[MjDoubleVec, Any]
    nodebody: Field[MjStringVec, Any]
    order: Field[int, Whole]
    passive: Field[int, Whole]
    poisson: Field[float, Real]
    priority: Field[int, Whole]
    radius: Field[float, Real]
    rgba: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    section: Field[mujoco._enums.mjtFlexSection, Whole]
    sectionsize: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    selfcollide: Field[mujoco._enums.mjtFlexSelf, Whole]
    shear: Field[float, Real]
    signature: Fixed[int]
    size: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    solimp: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    solmix: Field[float, Real]
    solref: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    stressyield: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    texcoord: Field[MjFloatVec, Any]
    thickness: Field[float, Real]
    vert: Field[MjDoubleVec, Any]
    vertbody: Field[MjStringVec, Any]
    young: Field[float, Real]

class MjsFrame:
    def add_body(self, default: MjsDefault | None=..., name: str | None=..., childclass: str | None=..., pos: Reals | None=..., quat: Reals | None=..., axisangle: Reals | None=..., xyaxes: Reals | None=..., zaxis: Reals | None=..., euler: Reals | None=..., mass: Real | None=..., ipos: Reals | None=..., iquat: Reals | None=..., inertia: Reals | None=..., iaxisangle: Reals | None=..., ixyaxes: Reals | None=..., izaxis: Reals | None=..., ieuler: Reals | None=..., fullinertia: Reals | None=..., mocap: Whole | None=..., gravcomp: Real | None=..., sleep: Whole | None=..., simple: Whole | None=..., fuse: Whole | None=..., userdata: Reals | None=..., explicitinertial: Whole | None=..., plugin: MjsPlugin | None=..., info: str | None=...) -> MjsBody: ...
    def add_camera(self, default: MjsDefault | None=..., name: str | None=..., pos: Reals | None=..., quat: Reals | None=..., axisangle: Reals | None=..., xyaxes: Reals | None=..., zaxis: Reals | None=..., euler: Reals | None=..., mode: Whole | None=..., targetbody: str | None=..., proj: Whole | None=..., resolution: Reals | None=..., output: Whole | None=..., fovy: Real | None=..., ipd: Real | None=..., intrinsic: Reals | None=..., sensor_size: Reals | None=..., focal_length: Reals | None=..., focal_pixel: Reals | None=..., principal_length: Reals | None=..., principal_pixel: Reals | None=..., userdata: Reals | None=..., info: str | None=...) -> MjsCamera: ...
    def add_frame(self, default: MjsFrame | None=..., name: str | None=..., childclass: str | None=..., pos: Reals | None=..., quat: Reals | None=..., axisangle: Reals | None=..., xyaxes: Reals | None=..., zaxis: Reals | None=..., euler: Reals | None=..., scale: Any | None=..., scaling: Whole | None=..., massscale: Real | None=..., info: str | None=...) -> MjsFrame: ...
    def add_geom(self, default: MjsDefault | None=..., name: str | None=..., type: Whole | None=..., pos: Reals | None=..., quat: Reals | None=..., axisangle: Reals | None=..., xyaxes: Reals | None=..., zaxis: Reals | None=..., euler: Reals | None=..., fromto: Reals | None=..., size: Any | None=..., contype: Whole | None=..., conaffinity: Whole | None=..., condim: Whole | None=..., priority: Whole | None=..., friction: Reals | None=..., solmix: Real | None=..., solref: Reals | None=..., solimp: Reals | None=..., margin: Real | None=..., gap: Real | None=..., surfacevel: Reals | None=..., adhesion: Real | None=..., mass: Real | None=..., density: Real | None=..., typeinertia: Whole | None=..., fluid_ellipsoid: Whole | None=..., fluid_coefs: Reals | None=..., material: str | None=..., rgba: Reals | None=..., group: Whole | None=..., castshadow: Whole | None=..., hfieldname: str | None=..., meshname: str | None=..., fitscale: Real | None=..., userdata: Reals | None=..., plugin: MjsPlugin | None=..., info: str | None=...) -> MjsGeom: ...
    def add_joint(self, default: MjsDefault | None=..., name: str | None=..., type: Whole | None=..., pos: Reals | None=..., axis: Reals | None=..., ref: Real | None=..., align: Whole | None=..., stiffness: Any | None=..., springref: Real | None=..., springyield: Real | None=..., springdamper: Reals | None=..., limited: Whole | None=..., range: Reals | None=..., margin: Real | None=..., solref_limit: Reals | None=..., solimp_limit: Reals | None=..., actfrclimited: Whole | None=..., actfrcrange: Reals | None=..., armature: Real | None=..., damping: Any | None=..., frictionloss: Real | None=..., solref_friction: Reals | None=..., solimp_friction: Reals | None=..., group: Whole | None=..., actgravcomp: Whole | None=..., userdata: Reals | None=..., info: str | None=...) -> MjsJoint: ...
    def add_light(self, default: MjsDefault | None=..., name: str | None=..., pos: Reals | None=..., dir: Reals | None=..., mode: Whole | None=..., targetbody: str | None=..., active: Whole | None=..., type: Whole | None=..., texture: str | None=..., castshadow: Whole | None=..., bulbradius: Real | None=..., intensity: Real | None=..., range: Real | None=..., attenuation: Reals | None=..., cutoff: Real | None=..., softness: Real | None=..., exponent: Real | None=..., ambient: Reals | None=..., diffuse: Reals | None=..., specular: Reals | None=..., info: str | None=...) -> MjsLight: ...
    def add_site(self, default: MjsDefault | None=..., name: str | None=..., pos: Reals | None=..., quat: Reals | None=..., axisangle: Reals | None=..., xyaxes: Reals | None=..., zaxis: Reals | None=..., euler: Reals | None=..., fromto: Reals | None=..., size: Any | None=..., type: Whole | None=..., material: str | None=..., group: Whole | None=..., rgba: Reals | None=..., meshname: str | None=..., userdata: Reals | None=..., info: str | None=...) -> MjsSite: ...
    alt: MjsOrientation
    def attach_body(self, body: MjsBody, prefix: str | None=..., suffix: str | None=...) -> MjsBody: ...
    childclass: str
    compiler: Fixed[MjsCompiler]
    frame: Fixed[MjsFrame]
    id: Fixed[int]
    info: str
    massscale: Field[float, Real]
    name: str
    parent: Fixed[MjsBody]
    pos: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    quat: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    scale: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    scaling: Field[mujoco._enums.mjtScaling, Whole]
    def set_frame(self, arg0: MjsFrame) -> None: ...
    signature: Fixed[int]

class MjsGeom:
    adhesion: Field[float, Real]
    alt: MjsOrientation
    castshadow: bool
    classname: MjsDefault
    compiler: Fixed[MjsCompiler]
    conaffinity: Field[int, Whole]
    condim: Field[int, Whole]
    contype: Field[int, Whole]
    density: Field[float, Real]
    fitscale: Field[float, Real]
    fluid_coefs: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    fluid_ellipsoid: Field[float, Real]
    frame: Fixed[MjsFrame]
    friction: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    fromto: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    gap: Field[float, Real]
    group: Field[int, Whole]
    hfieldname: str
    id: Fixed[int]
    info: str
    margin: Field[float, Real]
    mass: Field[float, Real]
    material: str
    meshname: str
    name: str
    parent: Fixed[MjsBody]
    plugin: MjsPlugin
    pos: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    priority: Field[int, Whole]
    quat: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    rgba: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    def set_frame(self, arg0: MjsFrame) -> None: ...
    signature: Fixed[int]
    size: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    solimp: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    solmix: Field[float, Real]
    solref: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    surfacevel: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    type: Field[mujoco._enums.mjtGeom, Whole]
    typeinertia: Field[mujoco._enums.mjtGeomInertia, Whole]
    userdata: Field[MjDoubleVec, Any]

class MjsHField:
    compiler: Fixed[MjsCompiler]
    content_type: str
    file: str
    id: Fixed[int]
    info: str
    name: str
    ncol: Field[int, Whole]
    nrow: Field[int, Whole]
    signature: Fixed[int]
    size: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    userdata: Field[MjFloatVec, Any]

class MjsJoint:
    actfrclimited: Field[mujoco._enums.mjtLimited, Whole]
    actfrcrange: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    actgravcomp: bool
    align: Field[mujoco._enums.mjtAlignFree, Whole]
    armature: Field[float, Real]
    axis: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    classname: MjsDefault
    compiler: Fixed[MjsCompiler]
    damping: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    frame: Fixed[MjsFrame]
    frictionloss: Field[float, Real]
    group: Field[int, Whole]
    id: Fixed[int]
    info: str
    limited: Field[mujoco._enums.mjtLimited, Whole]
    margin: Field[float, Real]
    name: str
    parent: Fixed[MjsBody]
    pos: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    range: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    ref: Field[float, Real]
    def set_frame(self, arg0: MjsFrame) -> None: ...
    signature: Fixed[int]
    solimp_friction: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    solimp_limit: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    solref_friction: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    solref_limit: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    springdamper: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    springref: Field[float, Real]
    springyield: Field[float, Real]
    stiffness: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    type: Field[mujoco._enums.mjtJoint, Whole]
    userdata: Field[MjDoubleVec, Any]

class MjsKey:
    act: Field[MjDoubleVec, Any]
    compiler: Fixed[MjsCompiler]
    ctrl: Field[MjDoubleVec, Any]
    id: Fixed[int]
    info: str
    mpos: Field[MjDoubleVec, Any]
    mquat: Field[MjDoubleVec, Any]
    name: str
    plastic: Field[MjDoubleVec, Any]
    qpos: Field[MjDoubleVec, Any]
    qvel: Field[MjDoubleVec, Any]
    signature: Fixed[int]
    time: Field[float, Real]

class MjsLight:
    active: bool
    ambient: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    attenuation: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    bulbradius: Field[float, Real]
    castshadow: bool
    classname: MjsDefault
    compiler: Fixed[MjsCompiler]
    cutoff: Field[float, Real]
    diffuse: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    dir: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    exponent: Field[float, Real]
    frame: Fixed[MjsFrame]
    id: Fixed[int]
    info: str
    intensity: Field[float, Real]
    mode: Field[mujoco._enums.mjtCamLight, Whole]
    name: str
    parent: Fixed[MjsBody]
    pos: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    range: Field[float, Real]
    def set_frame(self, arg0: MjsFrame) -> None: ...
    signature: Fixed[int]
    softness: Field[float, Real]
    specular: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    targetbody: str
    texture: str
    type: Field[mujoco._enums.mjtLightType, Whole]

class MjsMaterial:
    classname: MjsDefault
    compiler: Fixed[MjsCompiler]
    emission: Field[float, Real]
    id: Fixed[int]
    info: str
    metallic: Field[float, Real]
    name: str
    reflectance: Field[float, Real]
    rgba: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    roughness: Field[float, Real]
    shininess: Field[float, Real]
    signature: Fixed[int]
    specular: Field[float, Real]
    texrepeat: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    textures: Field[MjStringVec, Any]
    texuniform: bool

class MjsMesh:
    classname: MjsDefault
    compiler: Fixed[MjsCompiler]
    content_type: str
    file: str
    id: Fixed[int]
    inertia: Field[mujoco._enums.mjtMeshInertia, Whole]
    info: str
    def make_box(self, count: Wholes, spacing: Reals, dim: Whole=...) -> None: ...
    def make_cone(self, nedge: Whole, radius: Real) -> None: ...
    def make_cylinder(self, count: Wholes, spacing: Reals, dim: Whole=...) -> None: ...
    def make_disc(self, count: Wholes, spacing: Reals) -> None: ...
    def make_ellipsoid(self, count: Wholes, spacing: Reals, dim: Whole=...) -> None: ...
    def make_grid(self, count: Wholes, spacing: Reals, dim: Whole=...) -> None: ...
    def make_hemisphere(self, resolution: Whole) -> None: ...
    def make_plate(self, resolution: Wholes=...) -> None: ...
    def make_sphere(self, subdivision: Whole) -> None: ...
    def make_square(self, count: Wholes, spacing: Reals) -> None: ...
    def make_supersphere(self, resolution: Whole, e: Real, n: Real) -> None: ...
    def make_supertorus(self, resolution: Whole, radius: Real, s: Real, t: Real) -> None: ...
    def make_wedge(self, resolution: Wholes=..., fov: Reals=..., gamma: Real=...) -> None: ...
    material: str
    maxhullvert: Field[int, Whole]
    name: str
    needsdf: bool
    octree_maxdepth: Field[int, Whole]
    plugin: MjsPlugin
    refpos: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    refquat: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    scale: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    signature: Fixed[int]
    smoothnormal: bool
    userface: Field[MjIntVec, Any]
    userfacenormal: Field[MjIntVec, Any]
    userfacetexcoord: Field[MjIntVec, Any]
    usernode: Field[MjDoubleVec, Any]
    usernormal: Field[MjFloatVec, Any]
    usertet: Field[MjIntVec, Any]
    usertexcoord: Field[MjFloatVec, Any]
    uservert: Field[MjFloatVec, Any]

class MjsNumeric:
    compiler: Fixed[MjsCompiler]
    data: Field[MjDoubleVec, Any]
    id: Fixed[int]
    info: str
    name: str
    signature: Fixed[int]
    size: Field[int, Whole]

class MjsOrientation:
    axisangle: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    euler: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    type: Field[mujoco._enums.mjtOrientation, Whole]
    xyaxes: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    zaxis: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]

class MjsPair:
    adhesion: Field[float, Real]
    classname: MjsDefault
    compiler: Fixed[MjsCompiler]
    condim: Field[int, Whole]
    friction: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    gap: Field[float, Real]
    geomname1: str
    geomname2: str
    id: Fixed[int]
    info: str
    margin: Field[float, Real]
    name: str
    signature: Fixed[int]
    solimp: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    solref: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    solreffriction: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]

class MjsPlugin:
    active: bool
    compiler: Fixed[MjsCompiler]
    config: dict
    id: Field[int, MjsPlugin]
    info: str
    name: str
    plugin_name: str
    signature: Fixed[int]

class MjsSensor:
    compiler: Fixed[MjsCompiler]
    cutoff: Field[float, Real]
    datatype: Field[mujoco._enums.mjtDataType, Whole]
    delay: Field[float, Real]
    dim: Field[int, Whole]
    def get_data_size(self) -> int: ...
    id: Fixed[int]
    info: str
    interp: Field[int, Whole]
    interval: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    intprm: Field[NDArray[numpy.int32], numpy.typing.ArrayLike]
    name: str
    needstage: Field[mujoco._enums.mjtStage, Whole]
    noise: Field[float, Real]
    nsample: Field[int, Whole]
    objname: str
    objtype: Field[mujoco._enums.mjtObj, Whole]
    plugin: MjsPlugin
    refname: str
    reftype: Field[mujoco._enums.mjtObj, Whole]
    signature: Fixed[int]
    type: Field[mujoco._enums.mjtSensor, Whole]
    userdata: Field[MjDoubleVec, Any]

class MjsSite:
    alt: MjsOrientation
    def attach_body(self, body: MjsBody, prefix: str | None=..., suffix: str | None=...) -> MjsBody: ...
    classname: MjsDefault
    compiler: Fixed[MjsCompiler]
    frame: Fixed[MjsFrame]
    fromto: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    group: Field[int, Whole]
    id: Fixed[int]
    info: str
    material: str
    meshname: str
    name: str
    parent: Fixed[MjsBody]
    pos: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    quat: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    rgba: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    def set_frame(self, arg0: MjsFrame) -> None: ...
    signature: Fixed[int]
    size: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    type: Field[mujoco._enums.mjtGeom, Whole]
    userdata: Field[MjDoubleVec, Any]

class MjsSkin:
    bindpos: Field[MjFloatVec, Any]
    bindquat: Field[MjFloatVec, Any]
    bodyname: Field[MjStringVec, Any]
    compiler: Fixed[MjsCompiler]
    face: Field[MjIntVec, Any]
    file: str
    group: Field[int, Whole]
    id: Fixed[int]
    inflate: Field[float, Real]
    info: str
    material: str
    name: str
    rgba: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    signature: Fixed[int]
    texcoord: Field[MjFloatVec, Any]
    vert: Field[MjFloatVec, Any]
    vertid: Field[list[Any], Any]
    vertweight: Field[list[Any], Any]

class MjsTendon:
    actfrclimited: Field[mujoco._enums.mjtLimited, Whole]
    actfrcrange: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    armature: Field[float, Real]
    compiler: Fixed[MjsCompiler]
    damping: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    def default(self) -> MjsDefault: ...
    frictionloss: Field[float, Real]
    group: Field[int, Whole]
    id: Fixed[int]
    info: str
    limited: Field[mujoco._enums.mjtLimited, Whole]
    margin: Field[float, Real]
    material: str
    name: str
    path: Fixed[MjsTendonPath]
    range: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    rgba: Field[NDArray[numpy.float32], numpy.typing.ArrayLike]
    signature: Fixed[int]
    solimp_friction: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    solimp_limit: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    solref_friction: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    solref_limit: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    springlength: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    springyield: Field[float, Real]
    stiffness: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    userdata: Field[MjDoubleVec, Any]
    width: Field[float, Real]
    def wrap_geom(self, arg0: str, arg1: str) -> MjsWrap: ...
    def wrap_joint(self, arg0: str, arg1: Real) -> MjsWrap: ...
    def wrap_pulley(self, arg0: Real) -> MjsWrap: ...
    def wrap_site(self, arg0: str) -> MjsWrap: ...

class MjsTendonPath:
    def __getitem__(self, arg0: Whole) -> MjsWrap: ...
    def __len__(self) -> int: ...

class MjsText:
    compiler: Fixed[MjsCompiler]
    data: str
    id: Fixed[int]
    info: str
    name: str
    signature: Fixed[int]

class MjsTexture:
    builtin: Field[mujoco._enums.mjtBuiltin, Whole]
    classname: MjsDefault
    colorspace: Field[mujoco._enums.mjtColorSpace, Whole]
    compiler: Fixed[MjsCompiler]
    content_type: str
    cubefiles: Field[MjStringVec, Any]
    data: bytes
    embed: Field[mujoco._enums.mjtEmbed, Whole]
    file: str
    gridlayout: Field[MjCharVec, Any]
    gridsize: Field[NDArray[numpy.int32], numpy.typing.ArrayLike]
    height: Field[int, Whole]
    hflip: bool
    id: Fixed[int]
    info: str
    mark: Field[mujoco._enums.mjtMark, Whole]
    markrgb: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    name: str
    nchannel: Field[int, Whole]
    random: Field[float, Real]
    rgb1: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    rgb2: Field[NDArray[numpy.float64], numpy.typing.ArrayLike]
    signature: Fixed[int]
    type: Field[mujoco._enums.mjtTexture, Whole]
    vflip: bool
    width: Field[int, Whole]

class MjsTuple:
    compiler: Fixed[MjsCompiler]
    id: Fixed[int]
    info: str
    name: str
    objname: Field[MjStringVec, Any]
    objprm: Field[MjDoubleVec, Any]
    objtype: Field[MjIntVec, Any]
    signature: Fixed[int]

class MjsWrap:
    coef: Fixed[Any]
    divisor: Fixed[Any]
    info: str
    sidesite: Fixed[MjsSite]
    target: Fixed[Any]
    type: Field[mujoco._enums.mjtWrap, Whole]

