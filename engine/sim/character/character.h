/* sim/character: a capsule that a player or an agent walks about in a world. It is no body: it is moved by casts and by
 * planes ("collide and slide"; Catto, Box2D v3.1, mover.c; Rouwe, Jolt Physics, CharacterVirtual), so it does just what
 * it is asked and is never shoved about by the solver.
 *
 * Promises: however fast it moves, it does not pass through what stands still; where it overlaps something it is pushed
 * out; it climbs steps and slopes up to its limits and no higher; it stays on the ground when the ground falls away no
 * deeper than a step; the same calls give the same bits. It pushes dynamic bodies with a bounded force and rides on
 * what it stands on. Dynamic bodies do not feel it but for that.
 *
 * Public headers: character.h
 *
 * The state is a plain struct of the caller's: a copy of it is a saved character. Up is +Y. */
#ifndef DAFT_SIM_CHARACTER_H
#define DAFT_SIM_CHARACTER_H

#include "sim/query/query.h"

typedef struct daft_sim_character_def {
    daft_dvec3 position;    /* of the capsule's centre */
    float radius, height;   /* metres; height: the whole, at least twice the radius */
    float step_height;      /* what it climbs without a jump; 0 to half its height */
    float max_slope;        /* radians from level, 0 to 1.5: steeper ground is slid down */
    float acceleration;     /* m/s² with which it takes up the speed it is asked for, on the ground */
    float air_acceleration; /* the same in the air */
    float gravity_scale;    /* of the world's gravity along Y */
    float mass;             /* kg: its weight on what it stands on, and how hard it runs into things */
    float push_force;       /* N: the most it pushes bodies with */
    uint32_t layers, mask;  /* as those of shapes */
    uint32_t ignore;        /* a body that it passes through; 0: none */
} daft_sim_character_def;

/* 0.3 m in radius, 1.8 m high, climbs 0.35 m and 50 degrees, 80 kg, 400 N. */
daft_sim_character_def daft_default_sim_character_def(void);

typedef struct daft_sim_character {
    daft_sim_character_def def; /* its position is that of the start */
    daft_dvec3 position;
    daft_vec3 velocity; /* m/s, in the world */
    bool grounded;      /* stands on something that is not too steep */
    bool sliding;       /* touches ground that is */
    bool crushed;       /* is held between things that leave it too little room */
    uint32_t ground;    /* the body it stands on; 0: none */
    daft_vec3 ground_normal;
    daft_vec3 ground_velocity;  /* of what it stands on, where it stands */
    float turn;                 /* radians about Y by which what it stands on turned in the last move */
    daft_dvec3 ground_local;    /* its position seen from that body, */
    daft_dvec3 ground_position; /* which was here, */
    daft_quat ground_rotation;  /* turned so */
} daft_sim_character;

typedef struct daft_sim_walk_wish {
    daft_vec3 velocity; /* m/s; y counts for nothing */
    float jump;         /* m/s upwards, if it stands; 0: none */
} daft_sim_walk_wish;

/* False with a message for numbers out of range. */
bool daft_sim_character_init(daft_sim_character *character, const daft_sim_character_def *def, daft_error *error);
/* Moves it over dt seconds, 0 to 1. Call it after the world's step. False with a message, and nothing done, for numbers
 * that are not finite. */
bool daft_sim_character_move(daft_world *world, daft_sim_character *character, const daft_sim_walk_wish *wish, float dt,
                             daft_error *error);
/* There at once and off the ground; it keeps its velocity. */
bool daft_sim_character_teleport(daft_sim_character *character, daft_dvec3 position, daft_error *error);
/* Crouches or rises; its feet stay. False, without a message, where there is no room. */
bool daft_sim_character_set_height(daft_world *world, daft_sim_character *character, float height, daft_error *error);
uint64_t daft_sim_character_hash(const daft_sim_character *character, uint64_t seed);

#endif
