/*
 * Plays Vulkan commands that `cupola-lab calls --vulkan` wrote to files, and returns Vulkan's
 * answers: results, contents of images, buffers and the window, and the kinds of messages of the
 * validation layer if it is loaded. Each line of stdin names a file, which is played with a new
 * device. docs/calls.md describes the format.
 */
#include "player/player.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { PATIENCE = 60, MOST_NUMBERS = 8 };

static int answers;
static FILE *messages; /* output to stdout */
static volatile int line_number;

static void say(const char *text)
{
    size_t size = strlen(text);
    if (write(answers, text, size) != (ssize_t)size)
        exit(2);
}

static void crashed(int number)
{
    signal(number, SIG_DFL);
    char text[64];
    snprintf(text, sizeof text, "%d signal %d\n", line_number, number);
    say(text);
    _exit(1);
}

/* Adds the kinds of messages since the last call. */
static void add_messages(char *text, size_t room)
{
    static const char *const kinds[] = {"VUID", "UNASSIGNED", "SYNC", "BestPractices"};
    char line[4096];
    fflush(stdout);
    while (fgets(line, sizeof line, messages) != NULL) {
        fputs(line, stderr);
        for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++) {
            const size_t used = strlen(text);
            if (strncmp(line, kinds[i], strlen(kinds[i])) == 0 && used + 160 < room)
                snprintf(text + used, room - used, " %.*s", (int)strcspn(line, "( "), line);
        }
    }
    clearerr(messages);
}

static void answer(int result, unsigned long long digest)
{
    static char text[1 << 14];
    snprintf(text, sizeof text, "%d %x %llx", line_number, result != 0 ? (unsigned)result : (unsigned)it.code, digest);
    it.code = VK_SUCCESS;
    add_messages(text, sizeof text - 2);
    strcat(text, "\n");
    say(text);
}

static int make_image(const int *n)
{
    image_make(n[0] % SLOTS, n[1]);
    return 0;
}

/* set, image, filter, result */
static int write_set(const int *n)
{
    submit(false);
    it.now.is_valid = false;
    set_write(n[0] % SETS, n[1] % SLOTS, n[2], n[3] % SLOTS);
    return 0;
}

/*
 * buffer, matrix, place: written by the host. The last submitted command buffer may be submitted
 * again.
 */
static int write_matrix(const int *n)
{
    submit(false);
    matrix_write((unsigned char *)it.buffers[n[0] % 2].bytes + n[2] % 32 * MATRIX_STEP, n[1]);
    return 0;
}

static int end_pass(const int *n)
{
    (void)n;
    return pass_end();
}

static int submit_now(const int *n)
{
    (void)n;
    if (!it.is_recording)
        return SKIPPED;
    submit(false);
    return 0;
}

static int again(const int *n)
{
    (void)n;
    return submit_again();
}

static int choose_ways(const int *n)
{
    it.ways = n[0];
    return 0;
}

static int new_swapchain(const int *n)
{
    return swapchain_make(n[0]);
}

static const struct {
    const char *name;
    int (*run)(const int *n);
} lines[] = {
    {"image", make_image},        {"write-set", write_set},     {"write-matrix", write_matrix}, {"ways", choose_ways},
    {"pass", pass_begin},         {"end", end_pass},            {"clear-part", pass_clear},     {"query", pass_query},
    {"pipeline", draw_pipeline},  {"set", draw_set},            {"push", draw_push},            {"viewport", draw_viewport},
    {"scissor", draw_scissor},    {"vertices", draw_vertices},  {"draw", draw},                 {"indexed", draw_indexed},
    {"indirect", draw_indirect},  {"dispatch", dispatch},       {"copy", copy_images},          {"blit", blit_images},
    {"resolve", resolve_images},  {"to-buffer", copy_to_buffer}, {"from-buffer", copy_from_buffer}, {"buffers", copy_buffers},
    {"fill", fill_buffer},        {"update", update_buffer},    {"clear", clear_image},         {"levels", make_levels},
    {"submit", submit_now},       {"again", again},             {"swapchain", new_swapchain},
};

/* Adds the contents of images and buffers, and the results of ended queries. */
static int ask(const int *n, unsigned long long *digest)
{
    const int what = n[0] % (SLOTS + 3);
    if (it.pass.is_under_way)
        return SKIPPED;
    if (what < SLOTS || (what == WINDOW && it.is_acquired && it.has_content)) {
        *digest = image_digest(what);
    } else if (what == SLOTS + 1) {
        *digest = buffers_digest();
    } else if (what == SLOTS + 2) {
        submit(false);
        for (uint32_t i = 0; i < QUERIES; i++) {
            uint64_t samples = 0;
            if (!it.query_is_done[i])
                continue;
            check(vkGetQueryPoolResults(it.w.device, it.queries, i, 1, sizeof samples, &samples, sizeof samples,
                                        VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT));
            *digest = *digest * 8191 + samples + 1;
        }
    } else {
        return SKIPPED;
    }
    return 0;
}

static void play_line(char *line)
{
    int n[MOST_NUMBERS] = {0}, result = SKIPPED;
    unsigned long long digest = 0;
    char *rest = NULL, *word = strtok_r(line, " ", &rest), *number;
    if (word == NULL || word[0] == '#' || strcmp(word, "context") == 0)
        return;
    for (int i = 0; i < MOST_NUMBERS && (number = strtok_r(NULL, " ", &rest)) != NULL; i++)
        n[i] = (int)(strtol(number, NULL, 0) & 0xffff);
    if (strcmp(word, "ask") == 0)
        result = ask(n, &digest);
    else if (strcmp(word, "present") == 0)
        result = present(&digest);
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; i++)
        if (strcmp(word, lines[i].name) == 0)
            result = lines[i].run(n);
    answer(result, digest);
}

static void play(const char *path)
{
    static char line[4096];
    bool is_open = false;
    FILE *file = fopen(path, "r");
    if (file == NULL) {
        fprintf(stderr, "%s: cannot be read\n", path);
        exit(1);
    }
    line_number = 0;
    for (int number = 1; fgets(line, sizeof line, file) != NULL; number++) {
        line[strcspn(line, "\n")] = '\0';
        if (strncmp(line, "context ", 8) == 0) {
            objects_open(strcmp(line + 8, "followed") == 0);
            answer(0, 0);
            is_open = true;
        }
        line_number = number;
        if (is_open)
            play_line(line);
    }
    fclose(file);
    if (!is_open)
        return;
    submit(false);
    objects_close();
    answer(0, 0);
}

int main(void)
{
    static const int signals[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGALRM};
    static char path[4096];
    messages = tmpfile();
    answers = dup(STDOUT_FILENO);
    if (messages == NULL || answers < 0 || dup2(fileno(messages), STDOUT_FILENO) < 0)
        return 1;
    /* The layer appends to the file, so the messages are read with another file position. */
    snprintf(path, sizeof path, "/proc/self/fd/%d", fileno(messages));
    messages = fopen(path, "r");
    if (messages == NULL)
        return 1;
    for (size_t i = 0; i < sizeof signals / sizeof signals[0]; i++)
        signal(signals[i], crashed);
    while (fgets(path, sizeof path, stdin) != NULL) {
        path[strcspn(path, "\n")] = '\0';
        alarm(PATIENCE);
        play(path);
        alarm(0);
        say("end\n");
    }
    return 0;
}
