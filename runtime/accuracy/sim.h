/* sim: what the simulation of a scene costs with other substeps and rates, and how far it then goes from the way that a
 * very fine one takes. From moments of a game on, each setting simulates the same second, with nobody's hand in it;
 * settings take turns. */
#ifndef RUNTIME_ACCURACY_SIM_H
#define RUNTIME_ACCURACY_SIM_H

#include "daft.h"

#include <stdio.h>

enum { SIM_SETTINGS = 11, SIM_ROUNDS = 15, SIM_MOMENTS = 4, SIM_TICKS = 60, SIM_TEXT = 48, SIM_REFERENCE_HZ = 3840 };

typedef struct sim_setting {
    int substeps, rate; /* of each step; steps a second, a multiple of 60 */
    char text[SIM_TEXT];
    double times[SIM_MOMENTS][SIM_ROUNDS]; /* milliseconds of a tick of 1/60 s */
    int rounds[SIM_MOMENTS];
    double ms, spread; /* medians, and halves of the distances between quartiles; means over the moments */
    /* Over the second, against 3,840 steps: */
    double position;    /* m: root of the mean square over all bodies and ticks, of the moments the mean */
    double energy;      /* J: the mean distance of the total, of the moments the mean */
    double penetration; /* m: the deepest overlap of all */
    double joint_gap;   /* m: the widest gap of all */
    int beaten_by;      /* the setting that is faster or closer and not worse, beyond noise; -1: none */
} sim_setting;

typedef struct sim_def {
    daft_scene *scene;
    int moments;
    bool (*next)(void *user, daft_error *error); /* takes the game to its next moment */
    void *user;
    double seconds; /* of wall time that all of it may take */
} sim_def;

typedef struct sim_result {
    sim_def def;
    sim_setting settings[SIM_SETTINGS];
    int moments;         /* in which something could move */
    uint32_t bodies;     /* of the moment that had the most */
    double floor;        /* m: between references of 3,840 and 1,920 steps a second */
    double reference_ms; /* of a tick of the reference */
} sim_result;

/* Fails where nothing moves at any moment. The bodies are afterwards where they were at the last moment. */
bool sim_run(sim_result *self, const sim_def *def, daft_error *error);
/* The setting with the least error in position whose time and spread keep the budget; -1: none. */
int sim_choose(const sim_result *self, double budget_ms);

typedef struct sim_report_def {
    const sim_result *sim;
    const char *scene, *command, *folder;
    double budget_ms;
} sim_report_def;

void sim_print(const sim_report_def *def, FILE *out);
/* Writes index.html, points.csv and report.json into the folder. */
bool sim_write(const sim_report_def *def, daft_error *error);

#endif
