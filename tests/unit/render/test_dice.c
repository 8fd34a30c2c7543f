/* render: how even samples of a disc are. */
#include "render/dice.h"
#include "fixtures.h"

#include <math.h>

static const double PI = 3.14159265358979;

/* The fraction of a pixel's samples of so many rounds, each of so many rays, that lie beyond a line across the disc. */
static double beyond(uint32_t pixel, uint32_t rounds, uint32_t rays, double angle, double offset)
{
    uint32_t count = 0;
    for (uint32_t round = 0; round < rounds; round++) {
        const daft_dice d = daft_dice_throw(pixel % 67, pixel / 67, round, 5);
        for (uint32_t k = 0; k < rays; k++) {
            const double turn = 2 * PI * daft_dice_turn(d, k) / (1 << DAFT_TURN_BITS);
            count += sqrt((double)daft_dice_part(d, k, rays)) * cos(turn - angle) > offset;
        }
    }
    return (double)count / (rounds * rays);
}

/* The root of the mean square error, over that of independent samples. */
static double unevenness(uint32_t rounds, uint32_t rays)
{
    enum { PIXELS = 4000 };
    double sum = 0, random = 0;
    for (uint32_t pixel = 0; pixel < PIXELS; pixel++) {
        const double angle = 2 * PI * pixel * 0.7548776662, offset = fmod(pixel * 0.5698402910, 1.8) - 0.9;
        const double area = (acos(offset) - offset * sqrt(1 - offset * offset)) / PI;
        const double off = beyond(pixel, rounds, rays, angle, offset) - area;
        sum += off * off, random += area * (1 - area) / (rounds * rays);
    }
    return sqrt(sum / random);
}

/* Also where a pixel's samples, or pictures that follow each other, bring one ray each. By multiples of the golden
 * ratio from round to round the last two were 0.38 and 0.39. */
static void samples_are_even(void **unused)
{
    (void)unused;
    static const struct {
        uint32_t rounds, rays;
        double most;
    } kinds[] = {{1, 4, 0.75}, {1, 16, 0.5}, {4, 1, 0.65}, {16, 1, 0.55}, {4, 4, 0.5}, {16, 8, 0.28}, {16, 16, 0.25}};
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++) {
        const double found = unevenness(kinds[i].rounds, kinds[i].rays);
        print_message("%2u rounds of %2u rays: error %.3f of that of independent ones\n", kinds[i].rounds,
                      kinds[i].rays, found);
        assert_true(found < kinds[i].most);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(samples_are_even)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
