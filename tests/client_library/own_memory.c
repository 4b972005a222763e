/* A client whose memory is the caller's own:
     own_memory live PORT          plays over sockets until a few seconds went by without a call of the allocator
     own_memory live PORT N        the same, but the Nth call of the allocator gives nothing
     own_memory replay FILE        plays a recorded session over frames, for each N that there is
   FILE holds entries: time in s (double), size (uint32), that many bytes of a frame from the server. */
#define _GNU_SOURCE
#include <zoned_client.h>

#include <dirent.h>
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* ---- the C library's own allocator, behind one that finds out who calls */
extern void* __libc_malloc(size_t size);
extern void* __libc_calloc(size_t count, size_t size);
extern void* __libc_realloc(void* at, size_t size);
extern void __libc_free(void* at);

static int watching = 0;
static int asking = 0;
static unsigned long strays = 0;

static void note(const void* from) {
    Dl_info caller;
    if (!watching || asking) return;
    asking = 1;
    if (dladdr(from, &caller) != 0 && (strstr(caller.dli_fname, "libzoned_client") != NULL ||
                                       strstr(caller.dli_fname, "libstdc++") != NULL)) {
        ++strays;
    }
    asking = 0;
}

void* malloc(size_t size) {
    note(__builtin_return_address(0));
    return __libc_malloc(size);
}

void* calloc(size_t count, size_t size) {
    note(__builtin_return_address(0));
    return __libc_calloc(count, size);
}

void* realloc(void* at, size_t size) {
    note(__builtin_return_address(0));
    return __libc_realloc(at, size);
}

/* ---- the caller's allocator: counts, fails when it is told to, and finds what is written beside */
enum { GUARD = 16, HEAD = 32, QUIET = 300 };

typedef struct pool {
    unsigned long calls;
    unsigned long fails_at; /* 0: never */
    unsigned long failed;
    unsigned long blocks; /* that are out */
    size_t bytes;
    size_t most_bytes;
    unsigned long broken;
} pool;

static void* take(void* context, size_t size) {
    pool* p = context;
    char* block;
    if (++p->calls == p->fails_at) {
        ++p->failed;
        return NULL;
    }
    block = __libc_malloc(HEAD + size + GUARD);
    memcpy(block, &size, sizeof size);
    memset(block + sizeof size, 0x5A, HEAD - sizeof size);
    memset(block + HEAD, 0xCD, size); /* nobody may count on zeros */
    memset(block + HEAD + size, 0x5A, GUARD);
    ++p->blocks;
    p->bytes += size;
    if (p->bytes > p->most_bytes) p->most_bytes = p->bytes;
    return block + HEAD;
}

static void give(void* context, void* at) {
    pool* p = context;
    char* block = (char*)at - HEAD;
    size_t size;
    size_t i;
    memcpy(&size, block, sizeof size);
    for (i = sizeof size; i < HEAD; ++i) p->broken += block[i] != 0x5A;
    for (i = 0; i < GUARD; ++i) p->broken += block[HEAD + size + i] != 0x5A;
    --p->blocks;
    p->bytes -= size;
    memset(block, 0xDD, HEAD + size + GUARD); /* nor on what is given back */
    __libc_free(block);
}

static int failures = 0;

static void expect(int holds, const char* what, unsigned long n) {
    if (!holds) {
        fprintf(stderr, "not so at call %lu: %s\n", n, what);
        ++failures;
    }
}

static zoned_client* create(pool* p, size_t ticket_size) {
    static char ticket[8192];
    zoned_client_allocator allocator = {.size = sizeof allocator, .context = p, .allocate = take, .release = give};
    zoned_client_settings settings = {.size = sizeof settings, .name = "memory", .ticket = ticket,
                                      .ticket_size = ticket_size, .measure = 1, .allocator = &allocator};
    char error[256] = "";
    zoned_client* client = zoned_client_create(ZONED_CLIENT_ABI, &settings, error, sizeof error);
    if (client == NULL) {
        expect(p->failed == 1 && strcmp(error, "out of memory") == 0, error, p->fails_at);
        expect(p->blocks == 0, "a client that was not made holds memory", p->fails_at);
    }
    return client;
}

/* A client that ran out is closed, says so, does nothing more and holds nothing but itself. */
static void expect_end(pool* p, zoned_client* client) {
    zoned_client_stats_info stats = {.size = sizeof stats};
    zoned_client_event event = {.size = sizeof event};
    zoned_client_input input = {.size = sizeof input};
    const unsigned long n = p->fails_at;
    expect(zoned_client_get_state(client) == ZONED_CLIENT_CLOSED, "it is closed", n);
    expect(strcmp(zoned_client_trouble(client), "out of memory") == 0, "it says so", n);
    expect(p->blocks == 1, "it has given back all but itself", n);
    expect(zoned_client_poll(client, 1e6) == ZONED_CLIENT_CLOSED, "poll", n);
    expect(zoned_client_connect(client, "127.0.0.1", 1) == ZONED_CLIENT_FAILED, "connect", n);
    expect(zoned_client_begin(client) == ZONED_CLIENT_FAILED, "begin", n);
    expect(zoned_client_stream_frame(client, "x", 1) == ZONED_CLIENT_FAILED, "frame", n);
    expect(zoned_client_stats(client, &stats) == ZONED_CLIENT_FAILED, "stats", n);
    expect(zoned_client_next_event(client, &event, NULL, 0) == ZONED_CLIENT_FAILED, "event", n);
    expect(zoned_client_set_input(client, &input) == ZONED_CLIENT_FAILED, "input", n);
    expect(zoned_client_command(client, 16, "x", 1) == ZONED_CLIENT_FAILED, "command", n);
    expect(zoned_client_entities(client, NULL, 0) == 0, "entities", n);
    expect(zoned_client_next_frame(client, NULL, 0) == 0, "next frame", n);
}

static void destroy(pool* p, zoned_client* client) {
    zoned_client_destroy(client);
    expect(p->blocks == 0 && p->bytes == 0, "all is given back", p->fails_at);
    expect(p->broken == 0, "nothing is written beside its blocks", p->fails_at);
}

/* What a game does in a frame, after its poll. */
static void look(zoned_client* client) {
    static zoned_client_entity entities[256] = {{.size = sizeof(zoned_client_entity)}};
    static zoned_client_particle particles[64] = {{.size = sizeof(zoned_client_particle)}};
    static char payload[65536];
    const double along[3] = {0.0, 0.0, 1.0};
    zoned_client_avatar own = {.size = sizeof own};
    zoned_client_aim_info aim = {.size = sizeof aim};
    zoned_client_field_value field = {.size = sizeof field};
    zoned_client_event event = {.size = sizeof event};
    double hour;
    while (zoned_client_next_event(client, &event, payload, sizeof payload) == 1) {
    }
    if (zoned_client_entities(client, entities, 256) > 0) {
        zoned_client_field_named(client, entities[0].id, "health", &field);
    }
    if (zoned_client_own(client, &own) == 1) {
        zoned_client_aim(client, own.eye, along, 50.0, &aim);
    }
    zoned_client_particles(client, particles, 64);
    zoned_client_shared_value(client, "time_of_day", &hour);
}

static double now_s(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static int descriptors(void) {
    DIR* folder = opendir("/proc/self/fd");
    int count = 0;
    while (readdir(folder) != NULL) ++count;
    closedir(folder);
    return count;
}

/* ---- over sockets */
static int live(const char* port, unsigned long fails_at) {
    const struct timespec sixtieth = {0, 16666667};
    pool p = {.fails_at = fails_at};
    const int before = descriptors();
    unsigned long calls = 0;
    int quiet = 0; /* frames since the last call */
    int frame;
    zoned_client* client;
    watching = 1;
    client = create(&p, 0);
    if (client != NULL) {
        zoned_client_connect(client, "127.0.0.1", (uint16_t)atoi(port));
        for (frame = 0; frame < 2400 && quiet < QUIET && p.failed == 0; ++frame) {
            const int state = zoned_client_poll(client, now_s());
            if (state == ZONED_CLIENT_CLOSED && p.failed == 0) {
                fprintf(stderr, "%s\n", zoned_client_trouble(client));
                return 1;
            }
            look(client);
            quiet = p.calls == calls && zoned_client_entities(client, NULL, 0) > 0 ? quiet + 1 : 0;
            calls = p.calls;
            nanosleep(&sixtieth, NULL);
        }
        if (p.failed == 1) expect_end(&p, client);
        destroy(&p, client);
    }
    watching = 0;
    expect(strays == 0, "no memory but the caller's", fails_at);
    expect(descriptors() == before, "no descriptor is left", fails_at);
    printf("{\"calls\": %lu, \"quiet_frames\": %d, \"most_bytes\": %lu, \"failed\": %lu}\n", p.calls, quiet,
           (unsigned long)p.most_bytes, p.failed);
    return failures == 0 ? 0 : 1;
}

/* ---- over frames */
typedef struct recording {
    char* bytes;
    size_t size;
} recording;

static recording load(const char* file) {
    recording r = {NULL, 0};
    FILE* in = fopen(file, "rb");
    fseek(in, 0, SEEK_END);
    r.size = (size_t)ftell(in);
    rewind(in);
    r.bytes = __libc_malloc(r.size);
    if (fread(r.bytes, 1, r.size, in) != r.size) abort();
    fclose(in);
    return r;
}

/* Plays it in frames of a sixtieth of a second, until it ends or memory does. */
static void play(const recording* r, pool* p, zoned_client* client) {
    static char out[1 << 20];
    zoned_client_input input = {.size = sizeof input, .move_z = 1.0F};
    size_t at = 0;
    double end;
    int frame;
    memcpy(&end, r->bytes + r->size - sizeof end, sizeof end);
    zoned_client_begin(client);
    for (frame = 0; frame / 60.0 < end && p->failed == 0; ++frame) {
        zoned_client_set_input(client, &input);
        zoned_client_poll(client, 1.0 + frame / 60.0);
        if (frame % 30 == 0) zoned_client_command(client, 16, "hello", 5);
        while (zoned_client_next_frame(client, out, sizeof out) > 0) {
        }
        if (zoned_client_stream_wish(client) == ZONED_CLIENT_WISH_OPEN) zoned_client_stream_opened(client);
        while (at + sizeof(double) < r->size && p->failed == 0) {
            double when;
            uint32_t size;
            memcpy(&when, r->bytes + at, sizeof when);
            if (when > frame / 60.0) break;
            memcpy(&size, r->bytes + at + sizeof when, sizeof size);
            zoned_client_stream_frame(client, r->bytes + at + sizeof when + sizeof size, size);
            at += sizeof when + sizeof size + size;
        }
        look(client);
    }
}

static int replay(const char* file) {
    /* Tickets of these sizes shift where the client's own blocks end. */
    static const size_t shifts[] = {0, 40, 100, 200, 500, 1000, 2000, 4000};
    const recording r = load(file);
    unsigned long tried = 0;
    unsigned long most_bytes = 0;
    size_t i;
    watching = 1;
    for (i = 0; i < sizeof shifts / sizeof shifts[0]; ++i) {
        unsigned long n = 0;
        for (;;) {
            pool p = {.fails_at = n};
            zoned_client* const client = create(&p, shifts[i]);
            if (client != NULL) play(&r, &p, client);
            if (n == 0) {
                zoned_client_world world = {.size = sizeof world};
                expect(zoned_client_get_world(client, &world) == 0, "the recording leads into a world", n);
                expect(zoned_client_entities(client, NULL, 0) > 0, "and shows entities", n);
                most_bytes = p.most_bytes;
            } else if (p.failed == 1 && client != NULL) {
                expect_end(&p, client);
            }
            if (client != NULL) destroy(&p, client);
            if (failures > 10 || (n > 0 && p.failed == 0)) break;
            ++n;
            ++tried;
        }
    }
    watching = 0;
    expect(strays == 0, "no memory but the caller's", 0);
    printf("{\"tried\": %lu, \"most_bytes\": %lu}\n", tried, most_bytes);
    return failures == 0 ? 0 : 1;
}

int main(int argc, char** argv) {
    if (argc >= 3 && strcmp(argv[1], "live") == 0) {
        return live(argv[2], argc > 3 ? strtoul(argv[3], NULL, 10) : 0);
    }
    return argc == 3 && strcmp(argv[1], "replay") == 0 ? replay(argv[2]) : 2;
}
