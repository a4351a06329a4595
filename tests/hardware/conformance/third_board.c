/* A driver board in C, written from docs/reference/board-protocol.md alone.
 *
 * It has neither vibration sensor nor thermometer, both of which the page allows, and plays lists.
 * It has no clock: each line of its input is a time in ms and the bytes, in hexadecimal, that arrive
 * then. It answers each with one line: the bytes that it sends.
 *
 *     cc -std=c99 -o third_board third_board.c -lm && echo "0 2a49444e3f0a" | ./third_board
 */

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define LONGEST 96
#define POINTS 64
#define PER_LINE 8
#define ERRORS 8
#define ARGUMENTS (PER_LINE + 2)

static const double PI = 3.14159265358979;
static const double AMPLITUDE = 2.5, VOLTAGE = 16.5, LOWEST = 25000, HIGHEST = 40000;
static const double WATCHDOG_MS = 600, ONTIME_S = 300, STEP_MS = 4, EDGE_MS = 2;
static const double RESONANCE = 30500, VOLTS_PER_UM = 15 / 2.3, RAMP_S = 0.025, HOLD_S = 0.020;

enum state { OFF, RAMP, HOLD, LIST, OPEN, WDOG, LONGER };
static const char *const NAMES[] = {"OFF", "RAMP", "HOLD", "LIST", "OPEN", "WDOG", "LONG"};

static double now_s;
static unsigned boot;
static enum state state = OFF;
static double target, from, begun_s, heard_s, commanded_s; /* of ramp, watchdog, on-time */
static double open_hz, open_v;
static double list[POINTS];
static int length, played;
static double step_s, edge_s, mean, settled;
static int errors[ERRORS], waiting;
static char last_body[LONGEST + 1], last_answer[LONGEST + 60];
static unsigned last_sequence;

static const char *text(int code) {
    switch (code) {
    case 0: return "No error";
    case -104: return "Data type error";
    case -109: return "Missing parameter";
    case -113: return "Undefined header";
    case -221: return "Settings conflict";
    default: return "Data out of range";
    }
}

static int vibrates(void) { return state == RAMP || state == HOLD || state == LIST || state == OPEN; }

static double along(double a, double b, double part) {
    return a + (b - a) * (part >= 1 ? 1 : 0.5 - 0.5 * cos(PI * part));
}

/* The amplitude that is on the plate now; after DRIV a ramp begins at 0. */
static double due(double t) {
    if (state == RAMP) return along(from, target, (t - begun_s) / RAMP_S);
    if (state == HOLD) return target;
    if (state == LIST) {
        long n = (long)floor((t - begun_s) / step_s);
        double before = n ? list[(n - 1) % played] : settled;
        return along(before, list[n % played], (t - begun_s - n * step_s) / edge_s);
    }
    return 0;
}

static void off(enum state why) {
    state = why;
    target = 0;
}

/* What passes by itself. */
static void pass(double t) {
    if (state == RAMP && t >= begun_s + RAMP_S && target == 0) off(OFF);
    if (state == RAMP && t >= begun_s + RAMP_S + HOLD_S) state = HOLD;
    if (vibrates() && t - heard_s > WATCHDOG_MS / 1000) off(WDOG);
    if (vibrates() && t - commanded_s > ONTIME_S) off(LONGER);
}

static unsigned crc(const char *s, size_t n) {
    unsigned r = 0xFFFF;
    for (size_t i = 0; i < n; i++) {
        r ^= (unsigned)(unsigned char)s[i] << 8;
        for (int k = 0; k < 8; k++) r = (r & 0x8000 ? r << 1 ^ 0x1021 : r << 1) & 0xFFFF;
    }
    return r;
}

static void send_all(const char *s) {
    for (; *s; s++) printf("%02x", (unsigned)(unsigned char)*s);
}

/* A plain decimal: sign, up to seven digits, up to six after the point. */
static int number(const char *s, double *value) {
    const char *p = s + (*s == '+' || *s == '-');
    int whole = 0, after = 0, point = 0;
    for (; isdigit((unsigned char)*p); p++) whole++;
    if (*p == '.') for (point = 1, p++; isdigit((unsigned char)*p); p++) after++;
    if (*p || whole < 1 || whole > 7 || (point && after < 1) || after > 6) return 0;
    *value = strtod(s, NULL);
    return 1;
}

static int whole_number(double x) { return x == floor(x); }

static int outside(double x, double low, double high) { return x < low || x > high; }

struct command { const char *header; int fewest, most; };
static const struct command COMMANDS[] = {
    {"*IDN?", 0, 0}, {"*RST", 0, 0}, {"SYST:ERR?", 0, 0}, {"LIM?", 0, 0}, {"AMPL", 1, 1},
    {"DRIV", 2, 2}, {"OUTP", 1, 1}, {"LIST:LIM?", 0, 0}, {"LIST:AMPL", 2, 1 + PER_LINE},
    {"LIST:PLAY", 3, 3}, {"STAT?", 0, 0},
};
enum { IDN, RST, ERR, LIM, AMPL, DRIV, OUTP, LIST_LIM, LIST_AMPL, LIST_PLAY, STAT, COUNT };

static int to_amplitude(double x, double t) {
    if (outside(x, 0, AMPLITUDE)) return -222;
    if (x == 0 && (!vibrates() || state == OPEN)) { off(OFF); return 0; }
    from = due(t), begun_s = commanded_s = t, target = x, state = RAMP;
    return 0;
}

static int to_list(const double *x, int n) {
    if (!whole_number(x[0]) || outside(x[0], 1, length + 1)) return -222;
    for (int i = 1; i < n; i++) if (outside(x[i], 0, AMPLITUDE)) return -222;
    int first = (int)x[0] - 1;
    if (first + n - 1 > POINTS) return -222;
    if (state == LIST) return -221;
    memcpy(list + first, x + 1, sizeof *x * (size_t)(n - 1));
    length = first + n - 1;
    return 0;
}

static int play(const double *x, double t) {
    if (!whole_number(x[0]) || outside(x[0], 2, POINTS)) return -222;
    if (outside(x[1], STEP_MS, 1000 * ONTIME_S) || outside(x[2], EDGE_MS, x[1])) return -222;
    if (state != HOLD || x[0] != length) return -221;
    played = length, step_s = x[1] / 1000, edge_s = x[2] / 1000, settled = target, mean = 0;
    for (int i = 0; i < played; i++) mean += list[i] / played;
    begun_s = commanded_s = t, state = LIST;
    return 0;
}

static void status(char *value) {
    double volts = 0, hertz = RESONANCE, told = target;
    if (state == OPEN) volts = open_v, hertz = open_hz, told = 0;
    else if (state == LIST) {
        told = mean;
        for (int i = 0; i < played; i++) volts = fmax(volts, list[i] * VOLTS_PER_UM);
    } else if (vibrates()) volts = due(now_s) * VOLTS_PER_UM;
    sprintf(value, "%s,%.4f,,%.1f,%.3f,", NAMES[state], told, hertz, volts);
}

/* Run a body; return its code, and the value of its answer. */
static int run(char *body, char *value, double t) {
    char *words[ARGUMENTS + 1], *arguments = strchr(body, ' ');
    double x[ARGUMENTS] = {0};
    int which = 0, n = 0;
    if (arguments) *arguments++ = 0;
    if (arguments && !*arguments) arguments = NULL;
    while (which < COUNT && strcmp(COMMANDS[which].header, body)) which++;
    if (which == COUNT) return -113;
    while (arguments && n <= ARGUMENTS - 1) {
        char *comma = strchr(arguments, ',');
        if (comma) *comma++ = 0;
        words[n++] = arguments, arguments = comma;
    }
    if (n < COMMANDS[which].fewest) return -109;
    if (n > COMMANDS[which].most) return -104;
    if (which == OUTP) {
        if (strcmp(words[0], "OFF") && strcmp(words[0], "0")) return -222;
        off(OFF);
        return 0;
    }
    /* From left to right: what is no number before what is out of range further on. */
    for (int i = 0; i < n; i++) {
        if (!number(words[i], &x[i])) return -104;
        if (which == DRIV && (i ? outside(x[1], 0, VOLTAGE) : outside(x[0], LOWEST, HIGHEST)))
            return -222;
        if (which == LIST_AMPL && (i ? outside(x[i], 0, AMPLITUDE)
                                     : !whole_number(x[0]) || outside(x[0], 1, length + 1)))
            return -222;
        if (which == LIST_PLAY && i == 0 && (!whole_number(x[0]) || outside(x[0], 2, POINTS)))
            return -222;
        if (which == LIST_PLAY && i == 1 && outside(x[1], STEP_MS, 1000 * ONTIME_S)) return -222;
    }
    switch (which) {
    case IDN: strcpy(value, "Third,slipscale-plate-1,C-1,1.0"); return 0;
    case RST: off(OFF), waiting = length = 0; return 0;
    case ERR:
        sprintf(value, "%d,\"%s\"", waiting ? errors[0] : 0, text(waiting ? errors[0] : 0));
        if (waiting) memmove(errors, errors + 1, sizeof *errors * (size_t)--waiting);
        return 0;
    case LIM:
        sprintf(value, "%.1f,%.1f,%.0f,%.0f,%.0f,%.0f", AMPLITUDE, VOLTAGE, LOWEST, HIGHEST,
                WATCHDOG_MS, ONTIME_S);
        return 0;
    case AMPL: return to_amplitude(x[0], t);
    case DRIV: open_hz = x[0], open_v = x[1], commanded_s = t, target = 0, state = OPEN; return 0;
    case LIST_LIM: sprintf(value, "%d,%.0f,%.0f", POINTS, STEP_MS, EDGE_MS); return 0;
    case LIST_AMPL: return to_list(x, n);
    case LIST_PLAY: return play(x, t);
    default: status(value); return 0;
    }
}

static void answer(unsigned sequence, const char *body, double t) {
    heard_s = t;
    if (sequence != last_sequence || strcmp(body, last_body)) {
        char copy[LONGEST + 1], value[LONGEST] = "", frame[LONGEST + 40];
        strcpy(last_body, body), strcpy(copy, body);
        int code = run(copy, value, t);
        if (code) {
            if (waiting == ERRORS) memmove(errors, errors + 1, sizeof *errors * --waiting);
            errors[waiting++] = code;
            strcpy(value, text(code));
        }
        sprintf(frame, "%u %08X %d %s", sequence, boot, code, value);
        sprintf(last_answer, "<%s*%04X\n", frame, crc(frame, strlen(frame)));
        last_sequence = sequence;
    }
    send_all(last_answer);
}

static void line(char *s, size_t n, double t) {
    while (n && s[n - 1] == '\r') n--;
    s[n] = 0;
    if (!strcmp(s, "*IDN?") && n == 5) { send_all("Third,slipscale-plate-1,C-1,1.0\r\n"); return; }
    size_t last = n;
    while (last && s[last - 1] != '>') last--;
    if (!last || strlen(s + last) != n - last) return; /* noise before it may be of any bytes */
    char *start = s + last;
    char *star = strrchr(start, '*'), *space = strchr(start, ' '), *end;
    if (!star || !space || space > star || strlen(star) != 5) return;
    for (char *p = star + 1; *p; p++) if (!strchr("0123456789ABCDEF", *p)) return;
    if (strtoul(star + 1, NULL, 16) != crc(start, (size_t)(star - start))) return;
    if (*start < '1' || *start > '9' || space - start > 5) return;
    unsigned long sequence = strtoul(start, &end, 10);
    if (end != space || sequence > 65535) return;
    *star = 0;
    if (!space[1]) return;
    for (char *p = space + 1; *p; p++) if (*p < 0x20 || *p > 0x7E || *p == '<') return;
    answer((unsigned)sequence, space + 1, t);
}

int main(void) {
    static char buffer[LONGEST + 2], input[1 << 16];
    size_t n = 0;
    int too_long = 0;
    unsigned long ms = 0;
    unsigned byte;
    boot = (unsigned)time(NULL);
    while (fgets(input, sizeof input, stdin)) {
        char *hex;
        for (unsigned long end = strtoul(input, &hex, 10); ms < end; pass(now_s)) now_s = ++ms / 1000.0;
        for (hex++; sscanf(hex, "%2x", &byte) == 1; hex += 2) {
            if (byte == '!') {
                off(OFF), n = 0, too_long = 0;
            } else if (byte == '\n') {
                if (!too_long) line(buffer, n, now_s);
                n = 0, too_long = 0;
            } else if (n == LONGEST) {
                too_long = 1;
            } else {
                buffer[n++] = (char)byte;
            }
        }
        putchar('\n');
        fflush(stdout);
    }
    return 0;
}
