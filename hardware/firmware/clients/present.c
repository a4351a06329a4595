/* Presents one amplitude on a driver board (slipscale-plate-1), for programs in C. MIT licence.
 *
 *     cc -o present present.c && ./present /dev/ttyACM0 1.2 2.0     amplitude, seconds
 *
 * Prints the board's status ten times per second, which also feeds its watchdog, and ends with the
 * output off. A program that is killed feeds no watchdog: the board switches off by itself.
 */
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <termios.h>
#include <unistd.h>

#ifndef ANSWER_MS
#define ANSWER_MS 80
#endif

static int port, sequence;
static volatile sig_atomic_t interrupted;

static void interrupt(int number) { interrupted = number; }

static unsigned crc(const char *text, size_t length) {
    unsigned value = 0xFFFF;
    for (size_t i = 0; i < length; ++i) {
        value ^= (unsigned)(unsigned char)text[i] << 8;
        for (int bit = 0; bit < 8; ++bit)
            value = (value & 0x8000 ? value << 1 ^ 0x1021 : value << 1) & 0xFFFF;
    }
    return value;
}

/* Reads a line without its end; 0 if none arrives in time. */
static int line(char *text, size_t size) {
    struct pollfd ready = {port, POLLIN, 0};
    size_t length = 0;
    while (poll(&ready, 1, ANSWER_MS) > 0 && length + 1 < size && read(port, text + length, 1) == 1) {
        if (text[length] == '\n') {
            text[length] = '\0';
            return 1;
        }
        ++length;
    }
    return 0;
}

/* Sends a command up to four times and returns the board's answer, "CODE VALUE"; NULL if none. */
static const char *ask(const char *body) {
    static char answer[128];
    char frame[128], start[16];
    sequence = sequence % 65535 + 1;
    int length = snprintf(frame, sizeof frame, ">%d %s", sequence, body);
    snprintf(frame + length, sizeof frame - (size_t)length, "*%04X\n", crc(frame + 1, (size_t)length - 1));
    int prefix = snprintf(start, sizeof start, "<%d ", sequence);
    for (int attempt = 0; attempt < 4; ++attempt) {
        if (write(port, frame, strlen(frame)) < 0) return NULL;
        while (line(answer, sizeof answer)) {
            char *star = strrchr(answer, '*');
            if (star && !strncmp(answer, start, (size_t)prefix) &&
                strtoul(star + 1, NULL, 16) == crc(answer + 1, (size_t)(star - answer) - 1)) {
                *star = '\0';
                return answer + prefix + 9; /* after the eight digits of the board's start */
            }
        }
    }
    return NULL;
}

int main(int count, char **word) {
    struct termios mode;
    char body[64];
    if (count != 4 || (port = open(word[1], O_RDWR | O_NOCTTY)) < 0 || tcgetattr(port, &mode)) {
        fprintf(stderr, "usage: present PORT AMPLITUDE SECONDS (is the port there?)\n");
        return 2;
    }
    cfmakeraw(&mode);
    cfsetspeed(&mode, B115200);
    tcsetattr(port, TCSANOW, &mode);
    signal(SIGINT, interrupt);
    signal(SIGTERM, interrupt);
    snprintf(body, sizeof body, "AMPL %s", word[2]);
    const char *answer = ask(body);
    for (int tenth = 0; answer && *answer == '0' && !interrupted && tenth < 10 * atof(word[3]); ++tenth) {
        usleep(100000);
        if ((answer = ask("STAT?"))) printf("%s\n", answer + 2);
    }
    int failed = !answer || *answer != '0';
    if (failed) fprintf(stderr, "the board answered: %s\n", answer ? answer : "nothing");
    if (write(port, "!", 1) != 1) failed = 1; /* silences even a board that reads no frames */
    answer = ask("OUTP OFF");
    return failed || !answer || *answer != '0';
}
