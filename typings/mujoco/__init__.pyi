"""Types of what trajopt uses of mujoco 3.17.0: model specification, simulation and drawing."""

from typing import ClassVar, SupportsIndex, SupportsInt, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

_Integer: TypeAlias = SupportsInt | SupportsIndex

class _Int:
    """A field that reads as int and takes MuJoCo's enumerations too."""

    def __get__(self, instance: object, owner: type | None = None) -> int: ...
    def __set__(self, instance: object, value: _Integer) -> None: ...

class _Doubles:
    """A field that reads as a view of float64 and takes whatever has its length."""

    def __get__(self, instance: object, owner: type | None = None) -> NDArray[np.float64]: ...
    def __set__(self, instance: object, value: ArrayLike) -> None: ...

class _Singles:
    """A field that reads as a view of float32 and takes whatever has its length."""

    def __get__(self, instance: object, owner: type | None = None) -> NDArray[np.float32]: ...
    def __set__(self, instance: object, value: ArrayLike) -> None: ...

class FatalError(Exception): ...

# Enumerations: pybind11's, not Python's; none is an int, all turn into one.

class _Enum:
    @property
    def name(self) -> str: ...
    @property
    def value(self) -> int: ...
    def __init__(self, value: _Integer) -> None: ...
    def __int__(self) -> int: ...
    def __index__(self) -> int: ...

class mjtBuiltin(_Enum):
    mjBUILTIN_GRADIENT: ClassVar[mjtBuiltin]
    mjBUILTIN_CHECKER: ClassVar[mjtBuiltin]

class mjtCamera(_Enum):
    mjCAMERA_FREE: ClassVar[mjtCamera]
    mjCAMERA_FIXED: ClassVar[mjtCamera]

class mjtCatBit(_Enum):
    mjCAT_DYNAMIC: ClassVar[mjtCatBit]
    mjCAT_DECOR: ClassVar[mjtCatBit]
    mjCAT_ALL: ClassVar[mjtCatBit]

class mjtRndFlag(_Enum):
    mjRND_SHADOW: ClassVar[mjtRndFlag]
    mjRND_REFLECTION: ClassVar[mjtRndFlag]
    mjRND_SKYBOX: ClassVar[mjtRndFlag]
    mjRND_HAZE: ClassVar[mjtRndFlag]

class mjtDepthMap(_Enum):
    mjDEPTH_ZEROFAR: ClassVar[mjtDepthMap]

class mjtCone(_Enum):
    mjCONE_ELLIPTIC: ClassVar[mjtCone]

class mjtDisableBit(_Enum):
    mjDSBL_AUTORESET: ClassVar[mjtDisableBit]

class mjtEq(_Enum):
    mjEQ_JOINT: ClassVar[mjtEq]

class mjtFontScale(_Enum):
    mjFONTSCALE_150: ClassVar[mjtFontScale]

class mjtFramebuffer(_Enum):
    mjFB_OFFSCREEN: ClassVar[mjtFramebuffer]

class mjtGeom(_Enum):
    mjGEOM_PLANE: ClassVar[mjtGeom]
    mjGEOM_SPHERE: ClassVar[mjtGeom]
    mjGEOM_CAPSULE: ClassVar[mjtGeom]
    mjGEOM_CYLINDER: ClassVar[mjtGeom]
    mjGEOM_BOX: ClassVar[mjtGeom]
    mjGEOM_MESH: ClassVar[mjtGeom]

class mjtIntegrator(_Enum):
    mjINT_IMPLICITFAST: ClassVar[mjtIntegrator]

class mjtJoint(_Enum):
    mjJNT_SLIDE: ClassVar[mjtJoint]
    mjJNT_HINGE: ClassVar[mjtJoint]

class mjtLightType(_Enum):
    mjLIGHT_DIRECTIONAL: ClassVar[mjtLightType]

class mjtLimited(_Enum):
    mjLIMITED_FALSE: ClassVar[mjtLimited]
    mjLIMITED_TRUE: ClassVar[mjtLimited]

class mjtMark(_Enum):
    mjMARK_EDGE: ClassVar[mjtMark]

class mjtMeshInertia(_Enum):
    mjMESH_INERTIA_SHELL: ClassVar[mjtMeshInertia]

class mjtObj(_Enum):
    mjOBJ_JOINT: ClassVar[mjtObj]

class mjtTexture(_Enum):
    mjTEXTURE_2D: ClassVar[mjtTexture]
    mjTEXTURE_SKYBOX: ClassVar[mjtTexture]

class mjtTextureRole(_Enum):
    mjTEXROLE_RGB: ClassVar[mjtTextureRole]

class mjtTrn(_Enum):
    mjTRN_JOINT: ClassVar[mjtTrn]

# Options common to a specification and a compiled model.

class MjOption:
    timestep: float
    gravity: _Doubles
    integrator: _Int
    cone: _Int
    impratio: float
    noslip_iterations: int
    disableflags: int

class MjStatistic:
    center: _Doubles
    extent: float

class MjVisual:
    class Global:
        offwidth: int
        offheight: int
        fovy: float

    class Quality:
        shadowsize: int
        offsamples: int
        numslices: int
        numstacks: int

    class Map:
        haze: float
        shadowclip: float
        zfar: float
        znear: float

    @property
    def global_(self) -> Global: ...
    @property
    def quality(self) -> Quality: ...
    @property
    def map(self) -> Map: ...
    @property
    def headlight(self) -> MjVisualHeadlight: ...
    @property
    def rgba(self) -> MjVisualRgba: ...

class MjVisualHeadlight:
    ambient: _Singles
    diffuse: _Singles
    specular: _Singles

class MjVisualRgba:
    haze: _Singles

# Specification.

class MjStringVec:
    def __len__(self) -> int: ...
    def __getitem__(self, index: _Integer, /) -> str: ...
    def __setitem__(self, index: _Integer, text: str, /) -> None: ...

class MjFloatVec:
    def __len__(self) -> int: ...
    def __getitem__(self, index: _Integer, /) -> float: ...

class MjIntVec:
    def __len__(self) -> int: ...
    def __getitem__(self, index: _Integer, /) -> int: ...

class MjsCompiler:
    degree: bool
    autolimits: bool

class MjsGeom:
    name: str
    type: mjtGeom
    pos: _Doubles
    quat: _Doubles
    size: _Doubles
    mass: float
    contype: int
    conaffinity: int
    group: int
    rgba: _Singles
    material: str
    meshname: str

class MjsJoint:
    name: str
    type: mjtJoint
    axis: _Doubles
    armature: float
    limited: mjtLimited
    range: _Doubles

class MjsLight:
    name: str
    type: mjtLightType
    ambient: _Singles
    diffuse: _Singles
    specular: _Singles
    castshadow: bool

class MjsBody:
    name: str
    pos: _Doubles
    quat: _Doubles
    explicitinertial: bool
    mass: float
    inertia: _Doubles
    ipos: _Doubles
    iquat: _Doubles
    def add_body(
        self,
        *,
        name: str | None = None,
        pos: ArrayLike | None = None,
        quat: ArrayLike | None = None,
        mocap: bool | None = None,
    ) -> MjsBody: ...
    def add_freejoint(self, *, name: str | None = None) -> MjsJoint: ...
    def add_geom(
        self, *, name: str | None = None, type: _Integer | None = None, size: ArrayLike | None = None
    ) -> MjsGeom: ...
    def add_joint(
        self, *, name: str | None = None, type: _Integer | None = None, axis: ArrayLike | None = None
    ) -> MjsJoint: ...
    def add_light(self, *, name: str | None = None, type: _Integer | None = None) -> MjsLight: ...
    def add_camera(self, *, name: str | None = None) -> MjsCamera: ...

class MjsCamera:
    resolution: NDArray[np.int64]
    sensor_size: _Doubles
    focal_pixel: _Doubles
    principal_pixel: _Doubles

class MjsActuator:
    name: str
    target: str
    trntype: mjtTrn
    forcelimited: mjtLimited
    forcerange: _Doubles

class MjsEquality:
    type: mjtEq
    objtype: mjtObj
    name1: str
    name2: str
    data: _Doubles
    solref: _Doubles
    solimp: _Doubles

class MjsMesh:
    name: str
    inertia: mjtMeshInertia
    @property
    def uservert(self) -> MjFloatVec: ...
    @uservert.setter
    def uservert(self, value: ArrayLike) -> None: ...
    @property
    def userface(self) -> MjIntVec: ...
    @userface.setter
    def userface(self, value: ArrayLike) -> None: ...

class MjsTexture:
    name: str
    type: mjtTexture
    builtin: _Int
    mark: _Int
    rgb1: _Doubles
    rgb2: _Doubles
    markrgb: _Doubles

class MjsMaterial:
    name: str
    texrepeat: _Singles
    @property
    def textures(self) -> MjStringVec: ...

class MjsPair:
    geomname1: str
    geomname2: str
    condim: int
    friction: _Doubles
    solref: _Doubles
    solreffriction: _Doubles
    solimp: _Doubles

class MjSpec:
    modelname: str
    @property
    def compiler(self) -> MjsCompiler: ...
    @property
    def option(self) -> MjOption: ...
    @property
    def stat(self) -> MjStatistic: ...
    @property
    def visual(self) -> MjVisual: ...
    @property
    def worldbody(self) -> MjsBody: ...
    @property
    def equalities(self) -> list[MjsEquality]: ...
    def joint(self, name: str, /) -> MjsJoint: ...
    def __init__(self) -> None: ...
    def add_actuator(
        self, *, name: str | None = None, target: str | None = None, trntype: _Integer | None = None
    ) -> MjsActuator: ...
    def add_equality(self, *, type: _Integer | None = None, name1: str | None = None) -> MjsEquality: ...
    def add_material(
        self,
        *,
        name: str | None = None,
        texuniform: bool | None = None,
        specular: float | None = None,
        shininess: float | None = None,
    ) -> MjsMaterial: ...
    def add_mesh(self, *, name: str | None = None, inertia: _Integer | None = None) -> MjsMesh: ...
    def add_pair(self, *, geomname1: str | None = None, geomname2: str | None = None) -> MjsPair: ...
    def add_texture(
        self,
        *,
        name: str | None = None,
        type: _Integer | None = None,
        width: int | None = None,
        height: int | None = None,
    ) -> MjsTexture: ...
    def compile(self) -> MjModel: ...

# Simulation.

class _MjModelView:
    @property
    def id(self) -> int: ...
    @property
    def name(self) -> str: ...

class _MjBodyView(_MjModelView):
    @property
    def mocapid(self) -> NDArray[np.int32]: ...

class MjModel:
    ngeom: int
    nv: int
    @property
    def jnt_qposadr(self) -> NDArray[np.int32]: ...
    @property
    def jnt_dofadr(self) -> NDArray[np.int32]: ...
    @property
    def dof_damping(self) -> NDArray[np.float64]: ...
    @property
    def jnt_bodyid(self) -> NDArray[np.int32]: ...
    @property
    def body_parentid(self) -> NDArray[np.int32]: ...
    @property
    def pair_geom1(self) -> NDArray[np.int32]: ...
    @property
    def pair_geom2(self) -> NDArray[np.int32]: ...
    @property
    def geom_group(self) -> NDArray[np.int32]: ...
    @property
    def geom_dataid(self) -> NDArray[np.int32]: ...
    @property
    def mesh_vert(self) -> NDArray[np.float32]: ...
    @property
    def mesh_vertadr(self) -> NDArray[np.int32]: ...
    @property
    def mesh_vertnum(self) -> NDArray[np.int32]: ...
    @property
    def mesh_pos(self) -> NDArray[np.float64]: ...
    @property
    def mesh_quat(self) -> NDArray[np.float64]: ...
    @property
    def geom_rgba(self) -> NDArray[np.float32]: ...
    @property
    def light_dir(self) -> NDArray[np.float64]: ...
    @property
    def light_pos(self) -> NDArray[np.float64]: ...
    @property
    def stat(self) -> MjStatistic: ...
    @property
    def vis(self) -> MjVisual: ...
    def geom(self, name: int | str, /) -> _MjModelView: ...
    def body(self, name: int | str, /) -> _MjBodyView: ...
    def joint(self, name: int | str, /) -> _MjModelView: ...
    def light(self, name: int | str, /) -> _MjModelView: ...
    def camera(self, name: int | str, /) -> _MjModelView: ...
    @property
    def cam_pos(self) -> NDArray[np.float64]: ...
    @property
    def cam_quat(self) -> NDArray[np.float64]: ...

class _MjContactList:
    @property
    def dist(self) -> NDArray[np.float64]: ...
    @property
    def geom(self) -> NDArray[np.int32]: ...
    def __len__(self) -> int: ...

class MjData:
    @property
    def qpos(self) -> NDArray[np.float64]: ...
    @property
    def xpos(self) -> NDArray[np.float64]: ...
    @property
    def qvel(self) -> NDArray[np.float64]: ...
    time: float
    @property
    def mocap_pos(self) -> NDArray[np.float64]: ...
    @property
    def mocap_quat(self) -> NDArray[np.float64]: ...
    @property
    def ctrl(self) -> NDArray[np.float64]: ...
    @property
    def ncon(self) -> int: ...
    @property
    def contact(self) -> _MjContactList: ...
    def __init__(self, model: MjModel, /) -> None: ...

def mj_resetData(m: MjModel, d: MjData) -> None: ...
def mj_forward(m: MjModel, d: MjData) -> None: ...
def mj_step(m: MjModel, d: MjData, nstep: int = 1) -> None: ...
def mj_kinematics(m: MjModel, d: MjData) -> None: ...
def mj_camlight(m: MjModel, d: MjData) -> None: ...
def mj_fullM(m: MjModel, d: MjData, dst: NDArray[np.float64]) -> None: ...
def mj_ray(
    m: MjModel,
    d: MjData,
    pnt: NDArray[np.float64],
    vec: NDArray[np.float64],
    geomgroup: NDArray[np.uint8] | None,
    flg_static: bool,
    bodyexclude: int,
    geomid: NDArray[np.int32] | None,
    normal: NDArray[np.float64] | None = None,
) -> float: ...
def mj_multiRay(
    m: MjModel,
    d: MjData,
    pnt: NDArray[np.float64],
    vec: NDArray[np.float64],
    geomgroup: NDArray[np.uint8] | None,
    flg_static: bool,
    bodyexclude: int,
    geomid: NDArray[np.int32],
    dist: NDArray[np.float64],
    normal: NDArray[np.float64] | None,
    nray: int,
    cutoff: float,
) -> None: ...

# Drawing.

class MjvCamera:
    type: _Int
    fixedcamid: int
    lookat: _Doubles
    distance: float
    azimuth: float
    elevation: float
    def __init__(self) -> None: ...

class MjvOption:
    @property
    def geomgroup(self) -> NDArray[np.uint8]: ...
    def __init__(self) -> None: ...

class MjvPerturb:
    def __init__(self) -> None: ...

class MjvGeom:
    category: int
    rgba: _Singles

class MjvScene:
    ngeom: int
    @property
    def flags(self) -> NDArray[np.uint8]: ...
    @property
    def geoms(self) -> tuple[MjvGeom, ...]: ...
    def __init__(self, model: MjModel, maxgeom: int) -> None: ...

class MjrRect:
    def __init__(self, left: int, bottom: int, width: int, height: int) -> None: ...

class MjrContext:
    readDepthMap: _Integer
    def __init__(self, model: MjModel, fontscale: _Integer, /) -> None: ...
    def free(self) -> None: ...

def mjv_addGeoms(
    m: MjModel, d: MjData, opt: MjvOption, pert: MjvPerturb, catmask: int, scn: MjvScene
) -> None: ...
def mjv_updateScene(
    m: MjModel,
    d: MjData,
    opt: MjvOption,
    pert: MjvPerturb | None,
    cam: MjvCamera,
    catmask: int,
    scn: MjvScene,
) -> None: ...
def mjv_initGeom(
    geom: MjvGeom,
    type: _Integer,
    size: NDArray[np.float64],
    pos: NDArray[np.float64],
    mat: NDArray[np.float64],
    rgba: NDArray[np.float32],
) -> None: ...
def mjv_connector(
    geom: MjvGeom, type: _Integer, width: float, from_: NDArray[np.float64], to: NDArray[np.float64]
) -> None: ...
def mjr_setBuffer(framebuffer: _Integer, con: MjrContext) -> None: ...
def mjr_uploadMesh(m: MjModel, con: MjrContext, meshid: int) -> None: ...
def mjr_render(viewport: MjrRect, scn: MjvScene, con: MjrContext) -> None: ...
def mjr_readPixels(
    rgb: NDArray[np.uint8] | None, depth: NDArray[np.float32] | None, viewport: MjrRect, con: MjrContext
) -> None: ...
