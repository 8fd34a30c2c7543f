/* Reading text: numbers against the C library's, integers, joined lines, places, quotes. */
#include "geometry/formats/text.h"

#include "support_content.h"

#include <math.h>

static double number(const char *text)
{
    const char *cursor = text;
    double value = -12345;
    assert_true(daft_scan_number(&cursor, text + strlen(text), &value));
    assert_int_equal(*cursor, 0);
    return value;
}

static void numbers_are_read_right(void **unused)
{
    (void)unused;
    static const char *const forms[] = {"0",
                                        "-0",
                                        "1",
                                        "+1",
                                        "-1.5",
                                        ".5",
                                        "5.",
                                        "-.7e+2",
                                        ".8e-1",
                                        "1e10",
                                        "1E-10",
                                        "123456789012345",
                                        "0.000000123456789",
                                        "1234567.8901234",
                                        "0.1",
                                        "0.30000001192092896",
                                        "1e22",
                                        "8219.830078"};
    for (size_t i = 0; i < DAFT_COUNT_OF(forms); i++) assert_true(number(forms[i]) == strtod(forms[i], NULL));
    assert_true((float)number("3.4028235e38") == 3.4028235e38f && (float)number("1.17549435e-38") == 1.17549435e-38f);
    assert_true(isinf(number("3E4570711268")) && number("1e-4570711268") == 0 && number("0e99999999999999999999") == 0);
    assert_true(isinf(number("1e999999999999999999999")) && isinf(number("-inf")) && isinf(number("Infinity")));
    assert_true(isnan(number("nan")) && isnan(number("-nan(ind)")) && isnan(number("1.#QNAN")) &&
                isnan(number("-1.#IND")));
    static const char *const none[] = {"", "-", ".", "e5", "+-1", "x", "-.", "1e", "1e+", "infx"};
    for (size_t i = 0; i < DAFT_COUNT_OF(none); i++) {
        const char *cursor = none[i];
        double value = 0;
        bool all = daft_scan_number(&cursor, none[i] + strlen(none[i]), &value) && *cursor == 0;
        if (all) fail_msg("'%s' was read as %g", none[i], value);
    }
}

static void random_numbers_agree_with_strtod(void **unused)
{
    (void)unused;
    print_message("seed %llu\n", (unsigned long long)random_state);
    double worst = 0;
    for (int i = 0; i < 200000; i++) {
        char text[64];
        int before = (int)random_below(20), after = (int)random_below(20), used = 0;
        if (random_below(2)) text[used++] = '-';
        for (int k = 0; k < before; k++) text[used++] = (char)('0' + random_below(10));
        if (after || !before) text[used++] = '.';
        for (int k = 0; k < after + !before; k++) text[used++] = (char)('0' + random_below(10));
        text[used] = 0;
        if (random_below(3) == 0) snprintf(text + used, sizeof text - (size_t)used, "e%d", (int)random_below(60) - 30);
        double ours = number(text), theirs = strtod(text, NULL);
        bool is_short = before + after + !before <= 15 && !strchr(text, 'e');
        if (is_short && ours != theirs) fail_msg("%s: %.17g, not %.17g", text, ours, theirs);
        if (theirs != 0) worst = fmax(worst, fabs(ours / theirs - 1));
    }
    print_message("worst relative error of long numbers %.3g\n", worst);
    assert_true(worst < 4e-15);
}

static void integers_saturate(void **unused)
{
    (void)unused;
    static const struct {
        const char *text;
        int64_t value;
        size_t length;
    } cases[] = {{"7", 7, 1},
                 {"-12/3", -12, 3},
                 {"+5 ", 5, 2},
                 {"000000000000000000009", 1000000000000000, 21},
                 {"12345678", 12345678, 8},
                 {"123456789012345", 123456789012345, 15},
                 {"-99999999999999999999999999", -1000000000000000, 27},
                 {"1234567a", 1234567, 7}};
    for (size_t i = 0; i < DAFT_COUNT_OF(cases); i++) {
        const char *cursor = cases[i].text;
        int64_t value = 0;
        assert_true(daft_scan_integer(&cursor, cursor + strlen(cursor), &value));
        assert_true(value == cases[i].value && cursor == cases[i].text + cases[i].length);
    }
    const char *cursor = "-/1";
    int64_t value = 0;
    assert_false(daft_scan_integer(&cursor, cursor + 3, &value));
}

static void places_count_every_kind_of_line(void **unused)
{
    (void)unused;
    static const char text[] = "\xEF\xBB\xBFone\ntwo\rthree\r\n\nfive";
    daft_text t = daft_text_open("x", text, sizeof text - 1, NULL);
    int line = 0, column = 0;
    daft_text_place(&t, strstr(text, "one"), &line, &column);
    assert_true(line == 1 && column == 1);
    daft_text_place(&t, strstr(text, "wo"), &line, &column);
    assert_true(line == 2 && column == 2);
    daft_text_place(&t, strstr(text, "three"), &line, &column);
    assert_true(line == 3 && column == 1);
    daft_text_place(&t, strstr(text, "ve"), &line, &column);
    assert_true(line == 5 && column == 3);
}

static void quotes_can_be_shown(void **unused)
{
    (void)unused;
    assert_string_equal(daft_text_quote("K\xC3\xB6ln", 5).text, "K\xC3\xB6ln");
    assert_string_equal(daft_text_quote("a\tb\xC3", 4).text, "a?b?");
    assert_string_equal(daft_text_quote("\xff\x80z\x7f", 4).text, "??z?");
    char many[100];
    memset(many, 'x', sizeof many);
    daft_quoted quoted = daft_text_quote(many, sizeof many);
    assert_true(strlen(quoted.text) < sizeof quoted.text && strcmp(quoted.text + strlen(quoted.text) - 4, "x...") == 0);
}

static void joined_lines_are_blanks(void **unused)
{
    (void)unused;
    static const char text[] = "\t \\\n \\\r\n\\\rx \\y\\\nz\n";
    daft_text t = daft_text_open("x", text, sizeof text - 1, NULL);
    const char *p = daft_skip_blanks(text);
    assert_int_equal(*p, 'x');
    p = daft_skip_blanks(p + 1);
    assert_int_equal(p[0], '\\');
    p = daft_skip_token(&t, p);
    assert_int_equal(p[-1], 'y');
    assert_true(*daft_skip_blanks(p) == 'z' && daft_skip_statement(&t, text) == t.end - 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_are_read_right), cmocka_unit_test(random_numbers_agree_with_strtod),
        cmocka_unit_test(integers_saturate),      cmocka_unit_test(places_count_every_kind_of_line),
        cmocka_unit_test(quotes_can_be_shown),    cmocka_unit_test(joined_lines_are_blanks),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
