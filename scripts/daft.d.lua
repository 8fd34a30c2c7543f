---@meta
-- What games see as `daft`, for the Lua language server. `daft help annotations` prints this file: docs/tables.sh.

---@alias daft.vector number[]|{x: number, y: number, z: number}
---@alias daft.place daft.vector|daft.entity
---@alias daft.color string|number[]
---@alias daft.anymaterial string|daft.material|daft.material.options
---@alias daft.value string|number|boolean|table|nil
---@alias daft.shape {sphere?: number, box?: daft.vector, capsule?: {radius: number, height: number}, rotation?: number[]}
---@class daft.font
---@class daft.hit
---@field entity daft.entity
---@field distance number
---@field position number[]
---@field normal number[]
---@field inside boolean?
---@class daft.contact
---@field other daft.entity
---@field point daft.vector
---@field normal daft.vector
---@field impulse number
---@class daft.event
---@field kind string
---@field a daft.entity?
---@field b daft.entity?
---@field joint daft.joint?
---@field impulse number?
---@field speed number?
---@field point daft.vector?
---@field normal daft.vector?
---@class daft.clip
---@field name string
---@field duration number
---@class daft.animation
---@field clip string
---@field time number
---@field duration number
---@field speed number
---@field weight number
---@field loop boolean
---@field playing boolean

---@class daft
---@field load? fun()
---@field update? fun(dt: number)
---@field draw? fun()
---@field keypressed? fun(key: string)
---@field keyreleased? fun(key: string)
---@field textinput? fun(letter: string)
---@field keep? fun(): any
---@field reload? fun(old: any)
daft = {}

daft.query = {}

daft.light = {}

daft.sky = {}

daft.camera = {}

daft.input = {}

---In HUD units from the top left: 0, 0 to daft.width(), daft.height().
---@class daft.input.mouse
---@overload fun(): number, number
daft.input.mouse = {}

---Only in files of the game's folder tests/: what `daft test-game` runs, as a task beside the game, from the
---beginning of a game of its own. An error in it fails the test. scripts/test.lua has more for tests.
---@class daft.test
---@overload fun(name: string, f: function)
daft.test = {}

---@class daft.entity
---@field name string?
---@field data any
local entity = {}

---@class daft.joint
local joint = {}

---@class daft.character
local character = {}

---@class daft.material
local material = {}

---@class daft.mesh
local mesh = {}

---@class daft.light
local light = {}

---@class daft.image
local image = {}

---@class daft.stream
local stream = {}

---@class daft.particles
local particles = {}

---@class daft.picture
local picture = {}

---@class daft.sound
local sound = {}

---@class daft.voice
local voice = {}

---@class daft.entity.options
---@field mesh? daft.mesh|string The mesh that is drawn; an entity without mesh, sphere and box is a group
---@field sphere? number The sphere's radius (number, m, above 0); 0.5 unless given
---@field box? daft.vector The box's edge lengths; {1, 1, 1} unless given
---@field material? daft.anymaterial What it is made of; none: the mesh's own, or a light grey
---@field parent? daft.entity The entity within which position, rotation and scale are; none: the world
---@field position? daft.vector|daft.entity Where it is; {0, 0, 0} unless given
---@field rotation? table|daft.vector How it is turned
---@field scale? number|daft.vector How many times as large it is along its own axes; a sphere's is equal in all; 1 unless given
---@field visible? boolean Whether it is drawn and hit by rays; true unless given
---@field casts_shadow? boolean Whether it casts shadows; light comes through materials that transmit; true unless given
---@field body? "none"|"static"|"kinematic"|"dynamic" How the simulation moves it: not at all, as the game says, or by forces and contacts; "none" unless given
---@field collider? "hull"|"mesh"|table What the body is made of; none: what is drawn, of a mesh the hull where it is dynamic, else the triangles
---@field density? number The mass of a cubic metre of it (number, kg/m³, above 0); 1000 unless given
---@field mass? number Its mass; from the density unless given (number, kg, above 0)
---@field friction? number Coulomb's coefficient; between two bodies the geometric mean holds (number, 0 or more); 0.5 unless given
---@field static_friction? number The same for what does not slide yet; less than friction: the same as friction (number, 0 or more); 0 unless given
---@field restitution? number How much of a bounce comes back; between two bodies the larger holds (number, 0 to 1); 0 unless given
---@field rolling_resistance? number What brakes rolling, as a fraction of load times radius; the larger of two bodies' holds (number, 0 or more); 0 unless given
---@field surface? string The kind of its surface, for daft.surfaces
---@field surface_velocity? daft.vector The velocity of its surface in its own axes, as a conveyor's; {0, 0, 0} unless given
---@field gravity_scale? number The fraction of gravity that acts on it; 1 unless given
---@field damping? number The fraction of its velocity that it loses in a second, for small ones (number, 1/s, 0 or more); 0 unless given
---@field angular_damping? number The same of its angular velocity (number, 1/s, 0 or more); 0 unless given
---@field lock? string|table "rotation", "x", "y", "z": axes of the world about which it does not turn; "position", "position x", "position y", "position z": along which its centre of mass does not move
---@field layer? string|table The layers that it is in
---@field hits? string|table The layers that it meets; two bodies meet where each meets a layer of the other
---@field sensor? boolean Meets nothing; what enters and leaves it makes events; false unless given
---@field bullet? boolean Does not pass through fast dynamic bodies either; false unless given
---@field sleeps? boolean Whether it may fall asleep at rest; true unless given
---@field lights? boolean Whether what its material gives off lights what is around; false unless given
---@field velocity? daft.vector Of a body that moves
---@field angular_velocity? daft.vector Of a body that moves
---@field clip? string|number The clip of its mesh that it plays, looped: see e:play
---@field name? string e.name can be read and set; daft.find finds it
---@field tags? string|table What it is, for e:has_tag and daft.find
---@field data? any e.data can be read and set

---@class daft.joint.options
---@field kind? "ball"|"hinge"|"slider"|"distance"|"fixed"|"drag" ball: two points stay together; hinge: and so do two axes; slider: moves along an axis and does not turn; distance: a rod, rope or spring; fixed: does not move; drag: draws a point to a target; "ball" unless given
---@field a? daft.entity The first body; none: the world itself
---@field b? daft.entity The second body
---@field at? daft.vector|daft.entity Where, in the world; distance: the point on a; where b is unless given
---@field to? daft.vector|daft.entity distance: the point on b; drag: the target; where b is unless given
---@field axis? daft.vector Of a hinge, a slider, or a ball's cone, in the world; any length; {0, 1, 0} unless given
---@field limit? table|number Radians of a hinge, metres of a slider or a distance; a number: a ball's cone, a rope's length
---@field motor? table rad/s and N m, or m/s and N; of a ball: a brake, the friction of a shoulder
---@field spring? table distance: a spring about its length; hinge, slider: about 0; ball, fixed: the whole joint gives
---@field length? number Between the two points; 0: what it is now (number, m, 0 to 1e+07); 0 unless given
---@field break_force? number The mean over a tick at which it breaks; 0: never (number, N, 0 to 1e+30); 0 unless given
---@field break_torque? number The mean over a tick at which it breaks; 0: never (number, N m, 0 to 1e+30); 0 unless given
---@field collide? boolean Whether the two bodies still touch each other; false unless given

---@class daft.surfaces.options
---@field friction? number Coulomb's coefficient (number, 0 or more); 0 unless given
---@field static_friction? number The same for what does not slide yet (number, 0 or more); 0 unless given
---@field restitution? number How much of a bounce comes back (number, 0 to 1); 0 unless given
---@field rolling_resistance? number What brakes rolling, as a fraction of load times radius (number, 0 or more); 0 unless given

---@class daft.character.options
---@field position? daft.vector|daft.entity Of the capsule's centre; where entity is unless given
---@field radius? number Of the capsule (number, m, 0.001 to 1000); 0.3 unless given
---@field height? number Of the capsule, from end to end; at least twice the radius (number, m, 0.001 to 10000); 1.8 unless given
---@field step? number What it climbs without a jump; at most half its height (number, m, 0 to 5000); 0.35 unless given
---@field slope? number From level; it slides down ground that is steeper (number, rad, 0 to 1.5); 0.8727 unless given
---@field acceleration? number With which it takes up the speed it is asked for, on the ground (number, m/s², 0 to 1e+06); 60 unless given
---@field air_acceleration? number The same in the air (number, m/s², 0 to 1e+06); 12 unless given
---@field gravity? number The fraction of gravity that acts on it (number, 0 to 1000); 1 unless given
---@field mass? number What weighs on what it stands on (number, kg, 0 to 1e+09); 80 unless given
---@field force? number The most it pushes bodies with (number, N, 0 to 1e+09); 400 unless given
---@field layer? string|table The layers that it is in
---@field hits? string|table The layers that it meets
---@field entity? daft.entity One that goes where the character goes, or none; its own body is not in the way

---@class daft.query.ray.options
---@field static? boolean Whether static bodies are met; true unless given
---@field kinematic? boolean Whether kinematic bodies are met; true unless given
---@field dynamic? boolean Whether dynamic bodies are met; true unless given
---@field sensors? boolean Whether sensors are met as well; false unless given
---@field layer? string|table The layers that the query is in
---@field hits? string|table The layers that it meets, as between two bodies
---@field ignore? daft.entity An entity that it passes through, or none

---@class daft.picture.draw.options
---@field position? daft.vector|daft.entity Where it is; {0, 0, 0} unless given
---@field yaw? number 0 looks along +X, positive turns right, towards +Z (number, rad, -1e+06 to 1e+06); 0 unless given
---@field pitch? number Positive looks down (number, rad, -1e+06 to 1e+06); 0 unless given
---@field roll? number Positive leans right (number, rad, -1e+06 to 1e+06); 0 unless given
---@field fov? number The horizontal angle of view, below pi (number, rad, 1e-06 to 3.1415); 1.5707964 unless given

---@class daft.material.options
---@field ambient? daft.color|number The fraction of the ambient light that it reflects (Ka); 0.8 unless given
---@field color? daft.color Lambert's reflection, and that of ambient light unless ambient is given; white where there is a texture; {0.8, 0.8, 0.8} unless given
---@field specular? daft.color|number Phong's highlight (Ks); 0.2 unless given
---@field shininess? number Phong's exponent (Ns): higher is smaller (number, 0 to 1000); 30 unless given
---@field mirror? number The weight of the mirrored ray's light (number, 0 to 1); 0 unless given
---@field mirror_tint? daft.color The mirrored light is multiplied by it; {1, 1, 1} unless given
---@field roughness? number How rough it is where it mirrors or lets light through: 0 is smooth (Pr) (number, 0 to 1); 0 unless given
---@field emission? daft.color|number Light that it gives off by itself; it lights nothing else but from entities with lights; 0 unless given
---@field transmission? number The fraction of the light that passes through; the rest is left to color and ambient (number, 0 to 1); 0 unless given
---@field transmission_tint? daft.color The light that passes is multiplied by it at each surface; with a tint_distance, along its way; {1, 1, 1} unless given
---@field tint_distance? number The length in which light within the body takes on transmission_tint: twice as far, the square of it; 0: each surface tints (number, m, 0 or more); 0 unless given
---@field medium_priority? number Where bodies that let light through overlap, the one with the higher number is there alone, so that wine touches glass; 0: what lies around it counts as air (number, 0 to 255); 0 unless given
---@field refractive_index? number How strongly light is bent, and so mirrored: water 1.33, glass 1.5, diamond 2.42; 1: not at all (number, 0.001 to 10); 1.5 unless given
---@field texture? "name" An image: "checker" is textures/checker.png in the game's folder or in assets/
---@field texture_scale? number|table Repeats of the texture over one unit of u and of v; on boxes one unit is a metre; 1 unless given
---@field texture_offset? table Added to u and v once they are scaled; {0, 0} unless given
---@field texture_wrap? "repeat"|"clamp"|"mirror" What lies beyond the textures' edges; "repeat" unless given
---@field shading? "phong"|"physical" By Lambert and Phong, or physically: color is the base colour, of which metallic and roughness say the rest, as in glTF; "phong" unless given
---@field metallic? number How much of it is metal; physical shading alone (number, 0 to 1); 0 unless given
---@field ambient_texture? "name" The image that ambient is multiplied by; none: texture
---@field specular_texture? "name" The image that specular and mirror are multiplied by
---@field emission_texture? "name" The image that emission is multiplied by
---@field shininess_texture? "name" The image whose green shininess is multiplied by
---@field roughness_texture? "name" The image whose green roughness is multiplied by
---@field metallic_texture? "name" The image whose blue metallic is multiplied by
---@field normal_texture? "name" Normals in tangent space: red along u, green along v, blue outwards
---@field normal_strength? number Its slopes are multiplied by it (number, -100 to 100); 1 unless given
---@field bump_texture? "name" Heights, in green
---@field bump_strength? number The slope between a black texel and a white one beside it (number, -1000 to 1000); 1 unless given
---@field occlusion_texture? "name" By the image's red the ambient light is multiplied, as in glTF; other lights are not
---@field occlusion_strength? number How much of the light that it keeps away is kept away (number, 0 to 1); 1 unless given
---@field alpha? "opaque"|"mask"|"blend" mask: a hole where alpha is below alpha_cutoff; blend: what lies behind shows as much as alpha is below 1; "opaque" unless given
---@field opacity? number What alpha is multiplied by (number, 0 to 1); 1 unless given
---@field alpha_cutoff? number Where a mask has holes (number, 0 to 1); 0.5 unless given
---@field alpha_texture? "name" Its alpha or, where it has none, its green is the alpha; none: the alpha of texture
---@field reflection_texture? "name" What it mirrors in place of its surroundings: an image all around, as of a sky; phong shading alone

---@class daft.light.sun.options
---@field direction? daft.vector Where its light travels to: a spot's axis, straight off a rectangle; any length but zero; {0, -1, 0} unless given
---@field color? daft.color Its colour in linear light; values over 1 are brighter; a rectangle's radiance; {1, 1, 1} unless given
---@field shadow? boolean Whether entities cast shadows in it; true unless given
---@field disc? number Half the angle that its disc spans, for soft shadows; 0: they are sharp (number, rad, 0 to 0.785398); 0 unless given
---@field visible? boolean Whether its disc is seen in the sky, of 16 times its colour at most; false unless given

---@class daft.light.point.options
---@field position? daft.vector|daft.entity Where it is; the middle of a rectangle; {0, 0, 0} unless given
---@field color? daft.color Its colour in linear light; values over 1 are brighter; a rectangle's radiance; {1, 1, 1} unless given
---@field shadow? boolean Whether entities cast shadows in it; true unless given
---@field radius? number Of the ball that glows, for soft shadows; 0: a point, whose shadows are sharp (number, m, 0 to 1e+06); 0 unless given
---@field range? number Where its light ends, having faded all the way; 0: nowhere; points and spots are then equally bright at any distance (number, m, 0 to 1e+06); 0 unless given
---@field inverse_square? boolean Its light falls with the square of the distance: its colour is what it has at a metre; false unless given

---@class daft.light.spot.options
---@field position? daft.vector|daft.entity Where it is; the middle of a rectangle; {0, 0, 0} unless given
---@field direction? daft.vector Where its light travels to: a spot's axis, straight off a rectangle; any length but zero; {0, -1, 0} unless given
---@field color? daft.color Its colour in linear light; values over 1 are brighter; a rectangle's radiance; {1, 1, 1} unless given
---@field shadow? boolean Whether entities cast shadows in it; true unless given
---@field inner? number All of its light is within this angle of the direction; three quarters of angle where only that is given (number, rad, 0 to 3.14159); 0.3926991 unless given
---@field angle? number None of its light is beyond this angle of the direction (number, rad, up to 3.14159); 0.5235988 unless given
---@field radius? number Of the ball that glows, for soft shadows; 0: a point, whose shadows are sharp (number, m, 0 to 1e+06); 0 unless given
---@field range? number Where its light ends, having faded all the way; 0: nowhere; points and spots are then equally bright at any distance (number, m, 0 to 1e+06); 0 unless given
---@field inverse_square? boolean Its light falls with the square of the distance: its colour is what it has at a metre; false unless given

---@class daft.light.rectangle.options
---@field position? daft.vector|daft.entity Where it is; the middle of a rectangle; {0, 0, 0} unless given
---@field direction? daft.vector Where its light travels to: a spot's axis, straight off a rectangle; any length but zero; {0, -1, 0} unless given
---@field color? daft.color Its colour in linear light; values over 1 are brighter; a rectangle's radiance; {1, 1, 1} unless given
---@field shadow? boolean Whether entities cast shadows in it; true unless given
---@field range? number Where its light ends, having faded all the way; 0: nowhere; points and spots are then equally bright at any distance (number, m, 0 to 1e+06); 0 unless given
---@field size? table Of a rectangle: the level side, and the other; {1, 1} unless given
---@field turn? number How far a rectangle is turned about its direction, from the level side to the other (number, rad, -1e+06 to 1e+06); 0 unless given

---@class daft.fog.options
---@field color? daft.color Its own colour in linear light; {0.7, 0.7, 0.7} unless given
---@field density? number At base: exp(-density * metres) is left of light; 0: no fog (number, 1/m, 0 to 1000); 0 unless given
---@field height? number In which it thins to 1/e; 0: it is equally dense everywhere, and hides all of the sky (number, m, 0 to 1e+06); 0 unless given
---@field base? number Height in the world at which it has its density (number, m, -1e+06 to 1e+06); 0 unless given
---@field glow? number How much of the first sun's colour it has towards that (number, 0 to 1); 0 unless given

---@class daft.exposure.options
---@field ev? number Light is times 2^ev; where it is metered, so much brighter than it would be (number, stops, -24 to 24); 0 unless given
---@field auto? boolean Whether light is metered: the picture's mean of log2 luminance becomes middle grey, 0.18; false unless given
---@field curve? "none"|"aces"|"agx" How light that is brighter than white is shown: as white, or by a film's curve; "none" unless given

---@class daft.camera.set.options
---@field position? daft.vector|daft.entity Where it is; {0, 0, 0} unless given
---@field yaw? number 0 looks along +X, positive turns right, towards +Z (number, rad, -1e+06 to 1e+06); 0 unless given
---@field pitch? number Positive looks down (number, rad, -1e+06 to 1e+06); 0 unless given
---@field roll? number Positive leans right (number, rad, -1e+06 to 1e+06); 0 unless given
---@field fov? number The horizontal angle of view, below pi (number, rad, 1e-06 to 3.1415); 1.5707964 unless given
---@field teleport? boolean Whether it jumps there without a glide

---@class daft.camera.along.options
---@field position? daft.vector|daft.entity Where it is; {0, 0, 0} unless given
---@field yaw? number 0 looks along +X, positive turns right, towards +Z (number, rad, -1e+06 to 1e+06); 0 unless given
---@field pitch? number Positive looks down (number, rad, -1e+06 to 1e+06); 0 unless given
---@field roll? number Positive leans right (number, rad, -1e+06 to 1e+06); 0 unless given
---@field fov? number The horizontal angle of view, below pi (number, rad, 1e-06 to 3.1415); 1.5707964 unless given
---@field time? number When; in ascending order (number, s)

---@class daft.quality.options
---@field scale? number Sides of the drawn picture, relative to the shown one (number, 0.1 to 1); 1 unless given
---@field upscale? "bilinear"|"bicubic"|"nearest" How a picture that is drawn smaller is enlarged; "bilinear" unless given
---@field visibility? "exact"|"watertight"|"fast" How rays and triangles meet; "exact" unless given
---@field tree? "raster"|"bvh"|"kdtree" What camera rays are found by; the picture is the same; "raster" unless given
---@field samples? number Samples of a pixel (number, 1, 4, 8 or 16); 1 unless given
---@field edge_samples? number More samples where neighbours differ: 4, the corners, at outlines and creases; 16 at edges of shadows and in mirrors, too, and trilinear textures become anisotropic4 (number, 0, 4 or 16); 4 unless given
---@field edge_contrast? number Times the usual contrast from which pixels get these; below 1 fainter edges get some, and strong ones more of the 16 (number, 0.25 to 4); 1 unless given
---@field shadows? boolean Whether lights cast shadows; true unless given
---@field shadow_samples? number Rays of a point to each light that has a size or, of more than six, to those that are drawn for it; 0: shadows are sharp (number, 0 to 64); 1 unless given
---@field occlusion_samples? number Rays around a point, where the scene has ambient occlusion; 0: none (number, 0 to 64); 1 unless given
---@field mirror_depth? number Mirror bounces followed (number, 0 to 32); 2 unless given
---@field refraction_depth? number Surfaces that a path which passes through some may meet (number, 0 to 32); 12 unless given
---@field min_weight? number Mirrored and refracted rays that weigh less in all colours are not cast (number, 0 to 1); 0.00048828125 unless given
---@field glossy_samples? number Rays that a rough surface sends on; 0: none is rough (number, 0 to 64); 1 unless given
---@field texture_filter? "trilinear"|"mipmap"|"bilinear"|"nearest"|"anisotropic4"|"anisotropic16" What a texture's colour at a point is made of; "trilinear" unless given
---@field denoise? boolean Whether what is sampled is filtered; true unless given
---@field half_light? boolean Whether sampled shadows and occlusion that are filtered are found for one pixel in four; true unless given
---@field preset? "draft"|"game"|"high"|"reference" Sets all knobs to those of a preset, before the others are set
---@field target_ms? number What a frame may take, by pictures that are less exact where they must be; 0: whatever it takes. What the player asked for goes first (number from 1 to 1000, or 0)

---@class daft.entity.play.options
---@field speed? number 1 plays it as it was made; below 0: backwards, from its end (number, -1000 to 1000); 1 unless given
---@field blend? number In which the clip that plays passes over into it; 0, or where none plays: at once (number, s, 0 to 1000); 0 unless given
---@field start? number Into the clip, from the end where speed is below 0 (number, s, 0 to 1e+06); 0 unless given
---@field loop? boolean Begins anew at its end, or stays there; true unless given
---@field restart? boolean A clip that plays already begins anew; else it goes on, with this speed; false unless given

---@class daft.sound.options
---@field wave? "sine"|"triangle"|"saw"|"square"|"noise" From soft to harsh; "sine" unless given
---@field pitch? number At the beginning of the sound (number, Hz, 10 to 20000); 440 unless given
---@field slide? number At its end; where only the pitch is given, the same (number, Hz, 10 to 20000); 440 unless given
---@field attack? number Time in which it rises (number, s, 0.001 to 10); 0.005 unless given
---@field hold? number Time in which it stays (number, s, 0 to 10); 0 unless given
---@field decay? number Time in which it falls to nothing (number, s, 0.001 to 10); 0.3 unless given
---@field vibrato? number By which the pitch sways, up and down (number, semitones, 0 to 24); 0 unless given
---@field vibrato_rate? number How often it does (number, Hz, 0.1 to 50); 6 unless given
---@field duty? number Part of a square wave that is high: thin or full (number, 0.05 to 0.95); 0.5 unless given
---@field cut? number What is higher is softened; 0: nothing is (number, Hz, 0 to 20000); 0 unless given
---@field volume? number How loud it is (number, 0 to 1); 0.6 unless given
---@field beat? number Time from one note to the next (number, s, 0.01 to 10); 0.25 unless given
---@field notes? string A tune of such sounds, one each beat: "c4 e4 g#4 - bb4", - for a rest; it repeats without a gap

---@class daft.sound.play.options
---@field volume? number How loud, to the sound's own (number, 0 to 4); 1 unless given
---@field pitch? number How many times as fast (number, 0.0625 to 16); 1 unless given
---@field pan? number -1: left; 1: right (number, -1 to 1); 0 unless given
---@field loop? boolean Over and over, without a gap; false unless given
---@field near? number Up to this distance it has its full volume (number, m, 0.01 to 1e+06); 3 unless given
---@field far? number From this distance on it is silent: more than near; where only near is given, at least twice that (number, m, 0.02 to 2e+06); 100 unless given
---@field fade? number Time in which it rises (number, s, 0 to 60); 0 unless given
---@field group? string Whose volume daft.volume sets
---@field at? daft.vector|daft.entity Where it is, or the entity that carries it; without, it is everywhere

---@class daft.particles.options
---@field count? number The most at once (number, 1 to 50000); 1000 unless given
---@field material? daft.anymaterial What they look like; sparks and flames have an emission
---@field area? number Radius around their place in which they begin (number, m, 0 to 10000); 0 unless given
---@field direction? daft.vector Where they fly; {0, 1, 0} unless given
---@field spread? number The angle around it within which they do; pi: everywhere (number, rad, 0 to 3.14159); 0.5 unless given
---@field gravity? daft.vector What pulls them; {0, 0, 0} unless given
---@field drag? number The fraction of its speed that one loses in a second, where it is small (number, 1/s, 0 to 1000); 0 unless given
---@field rate? number How many begin in a second (number, 1/s, 0 to 3e+06); 0 unless given
---@field shape? "round"|"quad" Octagons, or squares with a texture's whole picture; "round" unless given
---@field position? daft.vector|daft.entity Where they begin: a place, or an entity that carries the system; {0, 0, 0} unless given
---@field speed? number|number[] Of each, chosen between the two; 1 unless given
---@field life? number|number[] Of each, chosen between the two; 1 unless given
---@field size? number|number[] The radius, from the beginning to the end of a life; 0.05 unless given
---@field seed? integer Of its sequence of random numbers; 0 unless given

---Makes an entity: at most one of mesh, sphere and box is drawn, and a body is simulated.
---@param options daft.entity.options
---@return daft.entity
function daft.entity(options) end

---Where it is, or puts it there (also {x, y, z}). Drawing glides from the last place to this one.
---@param x? number
---@param y? number
---@param z? number
---@return number
---@return number
---@return number
function entity:position(x, y, z) end

---Puts it there at once, without a glide.
---@param x number
---@param y number
---@param z number
function entity:teleport(x, y, z) end

---The rotation as a quaternion, or sets it from three angles or a quaternion's four numbers.
---@param yaw? number
---@param pitch? number
---@param roll? number
---@return number
---@return number
---@return number
---@return number
function entity:rotation(yaw, pitch, roll) end

---The scale, or sets it.
---@param s? number
---@param y? number
---@param z? number
---@return number
---@return number
---@return number
function entity:scale(s, y, z) end

---Gives it another material, as in daft.entity.
---@param material daft.anymaterial
function entity:material(material) end

---Whether it is drawn and hit by rays, or sets it.
---@param on? boolean
---@return boolean
function entity:visible(on) end

---Metres a second; of a body.
---@param x? number
---@param y? number
---@param z? number
---@return number
---@return number
---@return number
function entity:velocity(x, y, z) end

---Radians a second about each axis; of a body.
---@param x? number
---@param y? number
---@param z? number
---@return number
---@return number
---@return number
function entity:angular_velocity(x, y, z) end

---What touched it in the last step: a list of {other = entity, point = {x, y, z}, normal = {x, y, z},
---impulse = n}; the normal points away from the other. list: one to fill again.
---@param list? daft.contact[]|table
---@return daft.contact[]
function entity:contacts(list) end

---Takes it and its children out of the world.
function entity:destroy() end

---False once it has been destroyed.
---@return boolean
function entity:valid() end

---Plays a clip of its mesh, by name or number. One that plays already goes on; from another the pose passes
---over in `blend` seconds.
---@param clip string|integer
---@param options? {speed?: number, blend?: number, start?: number, loop?: boolean, restart?: boolean}
function entity:play(clip, options) end

---Back to the pose of the file.
function entity:stop() end

---The clips of its mesh: a list of {name = text, duration = seconds}.
---@return daft.clip[]
function entity:clips() end

---What it plays: {clip = name, time =, duration =, speed =, weight =, loop =, playing =}, or nil. weight is below
---1 while the pose passes over into it; playing is false once a clip that is not looped has ended.
---@return daft.animation|nil
function entity:animation() end

---Puts the clip that it plays at this time.
---@param seconds number
function entity:animation_time(seconds) end

---Where it is in the world, or puts it there; position is relative to its parent.
---@param x? number
---@param y? number
---@param z? number
---@return number
---@return number
---@return number
function entity:world_position(x, y, z) end

---The direction of its +X axis in the world: where it looks.
---@return number
---@return number
---@return number
function entity:forward() end

---The direction of its +Y axis in the world.
---@return number
---@return number
---@return number
function entity:up() end

---The direction of its +Z axis in the world.
---@return number
---@return number
---@return number
function entity:right() end

---Turns it, level, so that its +X axis points at a place or an entity.
---@param place daft.place
function entity:look_at(place) end

---What it hangs on, or hangs it there; nil: on the world. It stays where and as it is.
---@param entity? daft.entity|nil
---@return daft.entity|nil
function entity:parent(entity) end

---What hangs on it, in the order in which that came.
---@return daft.entity[]
function entity:children() end

---The entities of that name, or with that tag, or with all tags of a list; those that got it first come first.
---list: a table to fill, instead of a new one.
---@param options {tag?: string, name?: string}
---@param list? daft.entity[]|table
---@return daft.entity[]
function daft.find(options, list) end

---Gives it tags: names of what it is.
---@param tag string
---@param ... string
function entity:tag(tag, ...) end

---Takes tags from it.
---@param tag string
---@param ... string
function entity:untag(tag, ...) end

---Whether it has the tag.
---@param tag string
---@return boolean
function entity:has_tag(tag) end

---Its tags, in the order in which it got them.
---@return string[]
function entity:tags() end

---A force in newtons over the next step, at the centre of a dynamic body.
---@param x number
---@param y number
---@param z number
function entity:push(x, y, z) end

---A kick in kilograms times metres a second, at the centre of a dynamic body or at a point {x, y, z} of the world.
---@param x number
---@param y number
---@param z number
---@param point? daft.place
function entity:impulse(x, y, z, point) end

---A torque in newton metres over the next step.
---@param x number
---@param y number
---@param z number
function entity:torque(x, y, z) end

---A twist in kg·m²/s.
---@param x number
---@param y number
---@param z number
function entity:angular_impulse(x, y, z) end

---Of a body; 0 where it is not dynamic.
---@return number
function entity:mass() end

---Whether a body is awake; or wakes its island, or lets it sleep.
---@param on? boolean
---@return boolean
function entity:awake(on) end

---Gives a body other layers, as the fields layer and hits of daft.entity do.
---@param layer? string|string[]
---@param hits? string|string[]
function entity:layers(layer, hits) end

---Joins two bodies, or one and the world.
---@param options daft.joint.options
---@return daft.joint
function daft.joint(options) end

---Takes it away.
function joint:destroy() end

---False once it was destroyed, broke, or went with a body.
---@return boolean
function joint:valid() end

---A hinge's angle, a slider's displacement, a distance's length; and how fast it changes.
---@return number
---@return number
function joint:value() end

---What it had to hold, as the mean over the last step.
---@return number
---@return number
function joint:force() end

---Drives a hinge or slider at a speed with at most a force, or brakes a ball; nothing: off.
---@param speed? number
---@param force? number
function joint:motor(speed, force) end

---Limits its value; nothing: off.
---@param lower? number
---@param upper? number
function joint:limit(lower, upper) end

---Makes it a spring; nothing: stiff.
---@param hertz? number
---@param damping? number
function joint:spring(hertz, damping) end

---Where a drag joint draws to.
---@param x number
---@param y number
---@param z number
function joint:target(x, y, z) end

---What happened in the last step: {kind =, a =, b =, impulse =}. kind is "begin" or "end" of a contact, "enter" or
---"leave" of a sensor (a), "break" or "gone" of a joint (joint =), "sleep" or "wake" of a body (a). A begin has
---point =, normal = and speed =, too.
---@param list? daft.event[]|table
---@return daft.event[]
function daft.events(list) end

---Sets substeps = 1 to 16 (4 unless set) and sleeping = true or false. Gives counts of the last step: bodies, awake,
---joints, islands, pairs, contacts, rows, colours, substeps (the most of any island), sweeps.
---@param options? table
---@return table<string, integer>
function daft.physics(options) end

---What counts where two kinds of surface meet; without the table, what the bodies say.
---@param name string
---@param name2 string
---@param options? daft.surfaces.options
function daft.surfaces(name, name2, options) end

---The state of all bodies, joints and characters, for daft.load_bodies in the same run of the game.
---@return string
function daft.save_bodies() end

---Puts all bodies, joints and characters back as they were; the entities must be the same.
---@param string string
function daft.load_bodies(string) end

---A capsule that walks, climbs steps and slopes, slides along walls, rides, jumps, and pushes bodies.
---@param options daft.character.options
---@return daft.character
function daft.character(options) end

---Walks so from now on, in m/s.
---@param x number
---@param z number
function character:walk(x, z) end

---Upwards in m/s, if it stands in this tick.
---@param speed number
function character:jump(speed) end

---Of its middle; with arguments, it is there at once.
---@param x? number
---@param y? number
---@param z? number
---@return number
---@return number
---@return number
function character:position(x, y, z) end

---In m/s.
---@return number
---@return number
---@return number
function character:velocity() end

---What it stands on, and how: on ground, down a slope that is too steep, in the air, or held with too little room.
---@return daft.entity|nil
---@return "ground"|"slope"|"air"|"crushed"
function character:ground() end

---By which what it stands on turned it in the last tick.
---@return number
function character:turn() end

---With an argument it crouches or rises, and says whether there was room.
---@param metres? number
---@return number|boolean
function character:height(metres) end

---Takes it out of the game; its entity stays.
function character:destroy() end

---False once it has been destroyed.
---@return boolean
function character:valid() end

---The nearest body along a ray: {entity =, distance =, position =, normal =, inside =}. hit, list: tables to fill.
---@param from daft.place
---@param direction daft.vector
---@param max_distance? number
---@param options? daft.query.ray.options
---@param hit? daft.hit|table
---@return daft.hit|nil
function daft.query.ray(from, direction, max_distance, options, hit) end

---All bodies along a ray, nearest first, up to 256.
---@param from daft.place
---@param direction daft.vector
---@param max_distance? number
---@param options? daft.query.ray.options
---@param list? daft.hit[]|table
---@return daft.hit[]
function daft.query.all(from, direction, max_distance, options, list) end

---The same for a shape that moves: {sphere = radius}, {box = {x, y, z}} or {capsule = {radius, height}},
---and rotation.
---@param shape daft.shape
---@param from daft.place
---@param direction daft.vector
---@param max_distance? number
---@param options? daft.query.ray.options
---@param hit? daft.hit|table
---@return daft.hit|nil
function daft.query.cast(shape, from, direction, max_distance, options, hit) end

---The bodies that a shape overlaps, up to 256.
---@param shape daft.shape
---@param at daft.place
---@param options? daft.query.ray.options
---@param list? daft.entity[]|table
---@return daft.entity[]
function daft.query.overlap(shape, at, options, list) end

---The nearest point of any body.
---@param from daft.place
---@param max_distance? number
---@param options? daft.query.ray.options
---@param hit? daft.hit|table
---@return daft.hit|nil
function daft.query.closest(from, max_distance, options, hit) end

---Or "file.mtl#name". Where a material is wanted, such a table, a texture's name or a colour do too.
---@param options daft.material.options
---@return daft.material
function daft.material(options) end

---Changes what the table names of its material, for it alone.
---@param options table
function entity:repaint(options) end

---Changes what the table names, for everything that has this material.
---@param options daft.material.options
function material:set(options) end

---Loads a mesh, or makes one: positions is a list of {x, y, z}, triangles of {a, b, c} counted from 1,
---counter-clockwise seen from the front; normals and uvs are optional, one a position.
---{text = "HELLO", size = 1, depth = 0.2, align = "center", font =}: letters of that height and depth, in metres,
---seen from +z; the last line stands on y = 0, and x = 0 is its middle, "left" or "right" end. The same text and
---sizes give the same mesh.
---@param options string|{positions?: number[]|daft.vector[], triangles?: integer[][], normals?: number[]|daft.vector[], uvs?: number[]|number[][]}|{text?: string|number, size?: number, depth?: number, align?: "left"|"center"|"right", font?: daft.font}
---@return daft.mesh
function daft.mesh(options) end

---Moves the corners: as many positions as it was made with. The normals are computed again unless given.
---@param options {positions?: number[]|daft.vector[], normals?: number[]|daft.vector[]}
function mesh:set(options) end

---The lowest and highest coordinates.
---@return daft.vector
---@return daft.vector
function mesh:bounds() end

---Light from infinitely far.
---@param options daft.light.sun.options
---@return daft.light
function daft.light.sun(options) end

---Light from a point, equally bright at any distance unless it has a range or is inverse_square.
---@param options daft.light.point.options
---@return daft.light
function daft.light.point(options) end

---A point light that shines into a cone.
---@param options daft.light.spot.options
---@return daft.light
function daft.light.spot(options) end

---Makes lights of those that its mesh's file has, where it stands now, and lists them. Those of glTF have their
---candela or lux / pi as colour: bright ones need daft.exposure.
---@return daft.light[]
function entity:add_lights() end

---A rectangle that shines to one side, softly.
---@param options daft.light.rectangle.options
---@return daft.light
function daft.light.rectangle(options) end

---Changes what the table names.
---@param options daft.light.spot.options
function light:set(options) end

---Moves a light that is no sun.
---@param x number
---@param y number
---@param z number
function light:position(x, y, z) end

---Turns a light that is no point light.
---@param x number
---@param y number
---@param z number
function light:direction(x, y, z) end

---Values above 1 are brighter.
---@param color daft.color
function light:color(color) end

---Whether entities cast shadows in it.
---@param on boolean
function light:shadow(on) end

---Puts it out for good.
function light:destroy() end

---False once it has been destroyed.
---@return boolean
function light:valid() end

---Light from everywhere; what stands within so many metres of a surface keeps it away (ambient occlusion).
---@param color daft.color
---@param occlusion? number
function daft.ambient(color, occlusion) end

---Fog between what is seen and the camera; an empty table takes it away.
---@param options daft.fog.options
function daft.fog(options) end

---How bright the picture is shown, and by which curve what is brighter than white; an empty table: light as it is.
---@param options daft.exposure.options
function daft.exposure(options) end

---The same sky everywhere.
---@param color daft.color
function daft.sky.color(color) end

---A sky from one colour above to another at the horizon.
---@param zenith daft.color
---@param horizon daft.color
function daft.sky.gradient(zenith, horizon) end

---One equirectangular image around the world.
---@param options string
function daft.sky.image(options) end

---Six square image files as seen from within (px nx py ny pz nz of most sets): front towards -Z, right towards +X.
---@param right string
---@param left string
---@param top string
---@param bottom string
---@param front string
---@param back string
function daft.sky.cube(right, left, top, bottom, front, back) end

---The sky's own light, by the direction that a surface faces, in place of daft.ambient's colour; occlusion as there.
---@param strength? number
---@param occlusion? number
function daft.sky.light(strength, occlusion) end

---From a place to a place; either may be an entity: where it is now. fov is horizontal, in radians.
---teleport = true jumps there without a glide.
---@param options {from?: daft.place, at?: daft.place, fov?: number, teleport?: boolean}
function daft.camera.look(options) end

---What is not named stays.
---@param options daft.camera.set.options
function daft.camera.set(options) end

---The same fields but teleport.
---@return daft.camera.set.options
function daft.camera.get() end

---Where the camera is, as of daft.camera.get, so many seconds into a smooth path through a list of checkpoints.
---pace: "timed", "constant" or "eased".
---@param points daft.camera.along.options[]
---@param seconds number
---@param pace? string
---@return daft.camera.set.options
function daft.camera.along(points, seconds, pace) end

---The cameras that its mesh's file has, where it stands now, for daft.camera.set: by their numbers and names.
---@return table<integer|string, daft.camera.set.options>
function entity:cameras() end

---The checkpoints of the `path` items of scene files.
---@return daft.camera.along.options[]
function daft.camera.checkpoints() end

---Keys have SDL's names in lower case: "a", "left", "space", "return", "left shift", "f1", "mouse1".
---Letters, digits and signs are places: "a" is where a US keyboard has its A; daft.input.label tells what is there.
---@param key string
---@return boolean
function daft.input.down(key) end

---It went down in this tick.
---@param key string
---@return boolean
function daft.input.pressed(key) end

---It went up in this tick.
---@param key string
---@return boolean
function daft.input.released(key) end

---Names what the player does, by up to 8 keys, buttons and sticks: daft.input.bind("walk", "right", "-left",
---"left x"). A key counts as 1, with a minus before it as -1; of a stick, "+left x" is the right half. down,
---pressed and released take an action's name too. The pause menu lets players choose others.
---@param action string
---@param input string
---@param ... string
function daft.input.bind(action, input, ...) end

---The sum of its inputs, -1 to 1.
---@param action string
---@return number
function daft.input.action(action) end

---The player's key for it, or half of a stick, "+left x": to be shown. It differs from player to player, so only
---within daft.draw.
---@param action string
---@return string|nil
function daft.input.key_of(action) end

---What is printed on the player's key for an action, a key or a stick: "Q" for "a" on a French keyboard, "left
---stick up". nil: the player has nothing for it. Only within daft.draw.
---@param input string
---@return string|nil
function daft.input.label(input) end

---daft.textinput(letter) hears of each letter that is typed, as UTF-8. It is recorded.
---@param on boolean
function daft.input.text(on) end

---Shakes the gamepads: 0 to 1, up to 10 seconds.
---@param strength number
---@param seconds number
function daft.input.rumble(strength, seconds) end

---Two keys as an axis.
---@param negative string
---@param positive string
---@return number
function daft.input.axis(negative, positive) end

---A gamepad's: "left x", "left y", "right x", "right y", -1 to 1, right and down positive; "left trigger",
---"right trigger", 0 to 1. Its buttons are keys: "pad a", "pad start", "pad left shoulder", "pad up".
---@param name string
---@return number
function daft.input.stick(name) end

---Presses or releases a key from the next tick on: for bots. It is recorded.
---@param key string
---@param down boolean
function daft.input.set(key, down) end

---1 is left, 2 middle, 3 right.
---@param button integer
---@return boolean
function daft.input.mouse.down(button) end

---It went down in this tick.
---@param button integer
---@return boolean
function daft.input.mouse.pressed(button) end

---It went up in this tick.
---@param button integer
---@return boolean
function daft.input.mouse.released(button) end

---Notches turned in this tick; up and right are positive.
---@return number
---@return number
function daft.input.mouse.wheel() end

---Hides the mouse and keeps it in the window, to look around with its motion.
---@param on boolean
function daft.input.mouse.grab(on) end

---HUD units it went right and down in this tick, while it is grabbed.
---@return number
---@return number
function daft.input.mouse.motion() end

---Within daft.draw. align is "left", "center" or "right" of x; y is the top. size 28, white, with a shadow.
---With a width, lines are broken at blanks. The string has at most 16384 bytes of UTF-8; bytes that are none show
---as boxes, and so do letters that the font does not have.
---@param string string
---@param x number
---@param y number
---@param options? {size?: number, color?: daft.color, align?: "left"|"center"|"right", shadow?: boolean, font?: daft.font, width?: number}
function daft.text(string, x, y, options) end

---A TrueType file (.ttf) of the game's, for daft.text{font =}. The program's own font has Latin, Greek and
---Cyrillic letters. It holds the file and 4 MB while the game holds it.
---@param file string
---@return daft.font
function daft.font(file) end

---Of the widest line.
---@param string string
---@param size? number
---@param font? daft.font
---@return number
function daft.text_width(string, size, font) end

---Of the lines that it is broken into.
---@param string string
---@param width number
---@param size? number
---@param font? daft.font
---@return number
function daft.text_height(string, width, size, font) end

---The picture is 720 units high and as wide as its shape makes it. Recorded.
---@return number
function daft.width() end

---The picture's height in units.
---@return number
function daft.height() end

---A filled rectangle; "#rrggbbaa" shines through. With a width, its outline.
---@param x number
---@param y number
---@param width number
---@param height number
---@param color? daft.color|{color?: daft.color, width?: number}
function daft.rect(x, y, width, height, color) end

---2 wide where nothing else is said. Or through many points: daft.line({x, y, x, y, ...}, {closed = true}).
---@param x number
---@param y number
---@param x2 number
---@param y2 number
---@param color? daft.color|{color?: daft.color, width?: number}
function daft.line(x, y, x2, y2, color) end

---A disc; with a width, a ring.
---@param x number
---@param y number
---@param radius number
---@param color? daft.color|{color?: daft.color, width?: number}
function daft.circle(x, y, radius, color) end

---Fills what 3 to 1024 points enclose; with a width, its outline.
---@param options number[]
---@param color? daft.color|{color?: daft.color, width?: number}
function daft.polygon(options, color) end

---A picture file of the game's, to be drawn by image:draw.
---@param file string
---@return daft.image
function daft.image(file) end

---A pixel of it is a unit, times the scale; or it is as large as width and height say. rotation: radians clockwise
---about the origin, which is put at x, y: {0, 0} is the top left, {0.5, 0.5} the middle. source: {x, y, width,
---height} in its pixels. border: so many of its pixels at the edges are not stretched (nine patches). color
---multiplies it; smooth = false keeps its pixels square.
---@param x number
---@param y number
---@param options? {scale?: number, width?: number, height?: number, rotation?: number, origin?: number[], source?: number[], border?: number, color?: daft.color, smooth?: boolean}
function image:draw(x, y, options) end

---In pixels.
---@return number
---@return number
function image:size() end

---Nothing is drawn outside from here on; without numbers, everywhere again.
---@param x? number
---@param y? number
---@param width? number
---@param height? number
function daft.clip(x, y, width, height) end

---From here on coordinates go from 0, 0 to width, height, as large as fits, in the middle of the picture. Its left
---top and a unit in the picture's units come back: ((mouse x) - left) / scale. Without numbers: as at the start.
---@param width? number
---@param height? number
---@return number
---@return number
---@return number
function daft.canvas(width, height) end

---Calls the function at once, as a task: it may wait, and goes on in a later tick, after daft.update. An error in
---it is the game's.
---@param f function
---@param ... any
---@return thread
function daft.start(f, ...) end

---Only in a task: goes on after so many seconds of the game, in the next tick at the earliest. Also just wait(...).
---@param seconds? number
function daft.wait(seconds) end

---Only in a task: goes on in the first tick, from the next one on, in which the function says true. It is called
---once a tick. Also just wait_until(...).
---@param f function
function daft.wait_until(f) end

---Calls the function once, as a task, so many seconds from now.
---@param seconds number
---@param f function
---@return thread
function daft.after(seconds, f) end

---Calls the function again and again, as a task, first so many seconds from now; until it returns false.
---@param seconds number
---@param f function
---@return thread
function daft.every(seconds, f) end

---The task does not go on. One that has ended is left alone.
---@param task thread
function daft.cancel(task) end

---Whether the task runs or waits.
---@param task thread
---@return boolean
function daft.running(task) end

---The nearest visible entity along a ray: {entity =, distance =, position =, normal =, triangle =}.
---from may be an entity; ignore is one that the ray passes through; hit a table to fill.
---@param from daft.place
---@param direction daft.vector
---@param max_distance? number
---@param ignore? daft.entity
---@param hit? daft.hit|table
---@return daft.hit|nil
function daft.raycast(from, direction, max_distance, ignore, hit) end

---The ray from the camera through a point of the picture, in HUD units; the mouse's unless given.
---@param x? number
---@param y? number
---@return number[]
---@return number[]
function daft.screen_ray(x, y) end

---What is seen at a point of the picture, or under the mouse: what daft.raycast gives.
---@param x? number
---@param y? number
---@param max_distance? number
---@param ignore? daft.entity
---@param hit? daft.hit|table
---@return daft.hit|nil
function daft.pick(x, y, max_distance, ignore, hit) end

---In m/s²; 0, -9.81, 0 unless set.
---@param x number
---@param y number
---@param z number
function daft.gravity(x, y, z) end

---Of the game: ticks / 60, times what daft.time_scale said in each.
---@return number
function daft.time() end

---How fast the game's time goes from the next tick on: 1; slow motion below; 0: a pause; up to 4. dt of daft.update,
---the simulation, daft.time and tasks follow it; ticks do not.
---@param scale? number
---@return number
function daft.time_scale(scale) end

---Updates since the game began.
---@return number
function daft.tick() end

---Adds what a scene file describes; gives the entities that it names, by name.
---@param options string
---@return table<string, daft.entity>
function daft.scene(options) end

---Sets what a picture costs and how exact it is: preset =, target_ms = and knobs by name, such as samples =.
---Gives them all. What the player asked for goes first. Pictures alone change, never the game.
---@param options? daft.quality.options
---@return daft.quality.options
function daft.quality(options) end

---Starts the game afresh after this tick.
function daft.restart() end

---Ends the game after this tick.
function daft.quit() end

---What the game's window is like: its title, its size in points of the screen, whether it fills the screen, and an
---image file as its icon. What is not given stays; the player may change size and full screen at any time.
---@param options {title?: string, width?: number, height?: number, full_screen?: boolean, icon?: string}
function daft.window(options) end

---0 <= x < 1; or a whole number from 1 to m, or from m to n. The same in every run with the same seed;
---math.random is the same function. Within daft.draw it draws from a sequence of its own.
---@param m? number
---@param n? number
---@return number
function daft.random(m, n) end

---Starts the sequence again; math.randomseed is the same function.
---@param seed? number
function daft.randomseed(seed) end

---A sequence of random numbers of its own, which no other call disturbs.
---@param seed number
---@return daft.stream
function daft.random_stream(seed) end

---As daft.random, from this sequence.
---@param m? number
---@param n? number
---@return number
function stream:random(m, n) end

---Starts the sequence again.
---@param seed number
function stream:seed(seed) end

---Smooth noise between -1 and 1 in one to four dimensions, with one bump for each unit, about 0 on average.
---@param x number
---@param y? number
---@param z? number
---@param w? number
---@return number
function daft.noise(x, y, z, w) end

---Many small things that fly and are only seen: no ray and no body meets them.
---@param options daft.particles.options
---@return daft.particles
function daft.particles(options) end

---So many at once, as far as there is room.
---@param count integer
---@param place? daft.place
function particles:burst(count, place) end

---How many begin in a second.
---@param rate? number
---@return number
function particles:rate(rate) end

---Where they begin: a place, or an entity that carries them.
---@param place daft.place
function particles:position(place) end

---Where they fly.
---@param x number
---@param y number
---@param z number
function particles:direction(x, y, z) end

---How many there are now.
---@return number
function particles:count() end

---Takes away those that fly.
function particles:clear() end

---Takes it out of the game.
function particles:destroy() end

---False once it has been destroyed.
---@return boolean
function particles:valid() end

---What a camera of the game sees, for the game to read; up to 1,048,576 pixels. It has no pixels until it is drawn.
---@param options {width?: number, height?: number}
---@return daft.picture
function daft.picture(options) end

---Draws what the camera sees now. What is not named stays as in the last call; first it is daft.camera's default.
---@param options? daft.picture.draw.options
function picture:draw(options) end

---In pixels.
---@return number
---@return number
function picture:size() end

---Metres along the ray; math.huge where the sky is. Pixels count from 0, 0.
---@param x number
---@param y number
---@return number
function picture:depth(x, y) end

---nil where the sky is, or what has been destroyed since.
---@param x number
---@param y number
---@return daft.entity|nil
function picture:entity(x, y) end

---Of the surface, unit; zeros where the sky is.
---@param x number
---@param y number
---@return number
---@return number
---@return number
function picture:normal(x, y) end

---Linear light, not limited to 1.
---@param x number
---@param y number
---@return number
---@return number
---@return number
function picture:color(x, y) end

---The surface's own colour, linear; zeros where the sky is.
---@param x number
---@param y number
---@return number
---@return number
---@return number
function picture:albedo(x, y) end

---Pixels to the right and down that what is seen has moved since the picture was drawn before.
---@param x number
---@param y number
---@return number
---@return number
function picture:motion(x, y) end

---Of the entity's mesh, from 0.
---@param x number
---@param y number
---@return number
function picture:triangle(x, y) end

---Rays that were cast for the pixel.
---@param x number
---@param y number
---@return number
function picture:cost(x, y) end

---Keeps a value for later starts: numbers, strings, booleans, and tables of them with strings or
---whole numbers as keys, up to a million bytes. A crash or a power cut leaves the old value or the new
---one. nil forgets it. While a recording plays nothing is written.
---@param name string
---@param value daft.value
function daft.save(name, value) end

---What was saved last, in this start or an earlier one. The message says why a file cannot be read; it
---is kept beside the next one. Recordings hold what was loaded. A run without a window begins with nothing.
---@param name string
---@return number|nil
---@return string|nil
function daft.load_saved(name) end

---A sound from a WAV, OGG, FLAC or MP3 file, at most ten minutes long; or made of numbers.
---@param file string|daft.sound.options
---@return daft.sound
function daft.sound(file) end

---Plays it. What is at a place is muffled by bodies between it and the camera. 64 voices play at once; where one
---more begins, the one that is nearest its end goes.
---@param options? daft.sound.play.options
---@return daft.voice
function sound:play(options) end

---How long it is.
---@return number
function sound:seconds() end

---Fades it out.
---@param seconds? number
function voice:stop(seconds) end

---As in play. What has ended takes all of these, and nothing happens.
---@param v number
function voice:volume(v) end

---@param p number
function voice:pitch(p) end

---@param p number
function voice:pan(p) end

---Moves it there.
---@param place daft.place|daft.entity
function voice:at(place) end

---False once it has ended.
---@return boolean
function voice:playing() end

---Plays a sound over and over, in the group "music", while the one before fades out (1 s); nil: no more.
---@param sound? daft.sound
---@param options? {fade?: number, volume?: number}
function daft.music(sound, options) end

---The volume of a group of voices, or of "all": 0 to 4.
---@param group string
---@param v? number
---@return number
function daft.volume(group, v) end

---Only in a test: the picture after this tick is like tests/pictures/NAME.png. max is how far any channel of any
---pixel may be off, of 1 (0.25); mean is the mean over all (0.01).
---@param name string
---@param options? {max?: number, mean?: number}
function daft.test.picture(name, options) end

wait, wait_until = daft.wait, daft.wait_until
