/* Plays Godot's side of the interface for extensions: host EXTENSION.so PORT [--without FUNCTION].
   Loads the extension, takes its class and methods, and calls them as scripts do, untyped and
   typed, against a server on 127.0.0.1. Ends with 0 where all holds. */
#define _POSIX_C_SOURCE 199309L /* for clock_gettime */
#include "godot_side.h"
#include <dlfcn.h>
#include <math.h>
#include <string.h>
#include <time.h>

#define CRATES 10
#define WANDERERS 2
#define CHAT_COMMAND 1
#define CHAT_EVENT 18

/* ------------------------------------------------------------------ as scripts call */

static variant of_int(int64_t value) {
    variant v;
    to_variant(INT, &v, &value);
    return v;
}

static variant of_float(double value) {
    variant v;
    to_variant(FLOAT, &v, &value);
    return v;
}

static variant of_bytes(int type, const void* data, int64_t size) {
    variant v;
    memset(&v, 0, sizeof v);
    v.type = type;
    v.of.bytes[type == BYTES] = new_block(data, size);
    return v;
}

static variant of_text(const char* text) {
    return of_bytes(STRING, text, (int64_t)strlen(text));
}

static void clear(variant* v) {
    if (v->type == STRING) {
        drop(&v->of.text);
    } else if (v->type == BYTES) {
        drop(&v->of.bytes[1]);
    }
}

static const method* find(const char* name) {
    size_t i;
    for (i = 0; i < method_count; ++i) {
        if (strcmp(methods[i].name, name) == 0) {
            return &methods[i];
        }
    }
    fprintf(stderr, "the class has no method %s\n", name);
    exit(1);
}

static object* self;

/* With the arguments' types unknown before; gives the arguments back. */
static GDExtensionCallError try_call(const char* name,
                                     variant* arguments,
                                     int count,
                                     variant* result) {
    const method* const m = find(name);
    GDExtensionConstVariantPtr at[8];
    GDExtensionCallError error = {GDEXTENSION_CALL_ERROR_INVALID_METHOD, -1, -1};
    int i;
    for (i = 0; i < count; ++i) {
        at[i] = &arguments[i];
    }
    memset(result, 0, sizeof *result);
    m->call(m->data, self->instance, at, count, result, &error);
    for (i = 0; i < count; ++i) {
        clear(&arguments[i]);
    }
    return error;
}

static variant call(const char* name, int count, variant* arguments) {
    variant result;
    const GDExtensionCallError error = try_call(name, arguments, count, &result);
    if (error.error != GDEXTENSION_CALL_OK || result.type != find(name)->result) {
        fprintf(stderr, "%s: error %d, a result of type %d\n", name, (int)error.error, result.type);
        exit(1);
    }
    return result;
}

/* The same with types that were checked before; the arguments stay. */
static variant typed(const char* name, int count, variant* arguments) {
    const method* const m = find(name);
    GDExtensionConstTypePtr at[8];
    variant result;
    int i;
    CHECK((uint32_t)count == m->count);
    for (i = 0; i < count; ++i) {
        CHECK(arguments[i].type == m->type[i]);
        at[i] = &arguments[i].of;
    }
    memset(&result, 0, sizeof result);
    result.type = m->result;
    m->typed(m->data, self->instance, at, &result.of);
    return result;
}

/* Without arguments, or with one int: both ways have to give the same. */
static variant get(const char* name, int64_t index) {
    const uint32_t count = find(name)->count;
    variant argument = of_int(index);
    const variant one = call(name, (int)count, &argument);
    variant two = typed(name, (int)count, &argument);
    if (one.type == STRING || one.type == BYTES) {
        const int word = one.type == BYTES;
        const block* const a = one.of.bytes[word];
        const block* const b = two.of.bytes[word];
        CHECK((a != NULL ? a->size : 0) == (b != NULL ? b->size : 0));
        CHECK(a == NULL || b == NULL || memcmp(a->data, b->data, (size_t)a->size) == 0);
    } else {
        CHECK(memcmp(&one.of, &two.of, sizeof one.of) == 0);
    }
    clear(&two);
    return one;
}

static int64_t get_int(const char* name, int64_t index) {
    return get(name, index).of.integer;
}

static double get_float(const char* name) {
    return get(name, 0).of.number;
}

static int text_is(const char* name, int64_t index, const char* wanted) {
    variant v = get(name, index);
    const int same = strcmp(text_of(&v.of.text), wanted) == 0;
    clear(&v);
    return same;
}

static int text_has(const char* name, const char* wanted) {
    variant v = get(name, 0);
    const int found = strstr(text_of(&v.of.text), wanted) != NULL;
    clear(&v);
    return found;
}

static int poll_now(void) {
    struct timespec now;
    variant seconds;
    clock_gettime(CLOCK_MONOTONIC, &now);
    seconds = of_float((double)now.tv_sec + 1e-9 * (double)now.tv_nsec);
    return (int)call("poll", 1, &seconds).of.integer;
}

static void wait_a_frame(void) {
    const struct timespec sixtieth = {0, 16666667};
    nanosleep(&sixtieth, NULL);
}

static int connect_to(const char* host, int64_t port, const char* name) {
    variant arguments[3];
    arguments[0] = of_text(host);
    arguments[1] = of_int(port);
    arguments[2] = of_text(name);
    return call("connect_to_server", 3, arguments).of.truth;
}

static void walk_north(double speed) {
    variant arguments[5];
    arguments[0] = of_int(0); /* an int where a float is wanted, as in set_input(0, ...) */
    arguments[1] = of_float(speed);
    arguments[2] = of_float(0.0);
    arguments[3] = of_float(0.0);
    arguments[4] = of_int(0);
    CHECK(call("set_input", 5, arguments).of.truth);
}

/* ------------------------------------------------------------------ the play */

static void before_it_is_connected(void) {
    variant arguments[3];
    variant result;
    GDExtensionCallError error;
    CHECK(poll_now() == 0);
    CHECK(get_int("entity_count", 0) == 0 && get_int("entity_id", 5) == 0 &&
          get_int("entity_id", -1) == 0);
    CHECK(get_int("avatar_id", 0) == 0 && get_float("server_time") == 0.0);
    CHECK(text_is("trouble", 0, "") && text_is("entity_type", 0, ""));
    CHECK(get("avatar_position", 0).of.part[1] == 0.0F);
    CHECK(!get("next_event", 0).of.truth);
    error = try_call("entity_id", arguments, 0, &result);
    CHECK(error.error == GDEXTENSION_CALL_ERROR_TOO_FEW_ARGUMENTS && error.expected == 1 &&
          result.type == 0);
    arguments[0] = arguments[1] = of_int(1);
    error = try_call("entity_id", arguments, 2, &result);
    CHECK(error.error == GDEXTENSION_CALL_ERROR_TOO_MANY_ARGUMENTS && error.expected == 1);
    arguments[0] = of_text("localhost");
    arguments[1] = of_text("7777");
    arguments[2] = of_text("ann");
    error = try_call("connect_to_server", arguments, 3, &result);
    CHECK(error.error == GDEXTENSION_CALL_ERROR_INVALID_ARGUMENT && error.argument == 1 &&
          error.expected == INT);
    CHECK(!connect_to("127.0.0.1", 70000, "ann") && text_has("trouble", "port"));
    arguments[0] = of_text("no digits");
    call("set_pin", 1, arguments);
    CHECK(!connect_to("127.0.0.1", 7777, "ann") && text_has("trouble", "pin: wants 64 hex digits"));
    arguments[0] = of_text("");
    call("set_pin", 1, arguments);
}

static void sees_the_world(void) {
    int crates = 0;
    int wanderers = 0;
    int64_t i;
    for (i = 0; i < get_int("entity_count", 0); ++i) {
        const variant at = get("entity_position", i);
        const variant turn = get("entity_orientation", i);
        const float* const q = turn.of.part;
        CHECK(fabs(sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]) - 1.0) < 1e-3);
        CHECK(fabsf(at.of.part[0]) < 1000.0F && at.of.part[1] > 0.0F && at.of.part[1] < 10.0F);
        CHECK(get_int("entity_id", i) > 0);
        crates += text_is("entity_type", i, "crate");
        wanderers += text_is("entity_type", i, "wanderer");
    }
    printf("sees %d crates, %d wanderers\n", crates, wanderers);
    CHECK(crates == CRATES && wanderers == WANDERERS);
}

static void joins_and_walks(int port) {
    double north = 0.0;
    int frame;
    variant result;
    CHECK(connect_to("127.0.0.1", port, "ann"));
    for (frame = 0; frame < 1200 && (get_int("avatar_id", 0) == 0 ||
                                     get_int("entity_count", 0) < CRATES + WANDERERS);
         ++frame) {
        CHECK(poll_now() != 4);
        wait_a_frame();
    }
    CHECK(poll_now() == 2);
    sees_the_world();
    north = get("avatar_position", 0).of.part[2];
    walk_north(1.0);
    for (frame = 0; frame < 600 && get("avatar_position", 0).of.part[2] < north + 3.0; ++frame) {
        CHECK(poll_now() == 2);
        wait_a_frame();
    }
    result = get("avatar_position", 0);
    printf("walked %.2f m, round trip %.1f ms, corrected by %.4f m\n",
           result.of.part[2] - north,
           get_float("rtt_ms"),
           get_float("correction_m"));
    CHECK(result.of.part[2] >= north + 3.0);
    CHECK(get("avatar_eye", 0).of.part[1] > result.of.part[1]);
    walk_north(0.0);
    CHECK(get_float("rtt_ms") > 0.0 && get_float("server_time") > 0.0 &&
          get_float("correction_m") < 0.1);
}

/* A chat of the sandbox game, as Protocol Buffers: its topic and its text. */
static void speaks_and_hears(void) {
    static const char kChat[] = "\x0a\x05world\x12\x08good day";
    variant arguments[2];
    int frame;
    int heard = 0;
    arguments[0] = of_int(CHAT_COMMAND);
    arguments[1] = of_bytes(BYTES, kChat, sizeof kChat - 1);
    CHECK(call("send_command", 2, arguments).of.truth);
    for (frame = 0; frame < 600 && !heard; ++frame) {
        CHECK(poll_now() == 2);
        while (call("next_event", 0, NULL).of.truth) {
            variant payload = get("event_payload", 0);
            const block* const b = payload.of.bytes[1];
            if (get_int("event_kind", 0) == CHAT_EVENT) {
                heard = b->size > 8 && memcmp(b->data + b->size - 8, "good day", 8) == 0 &&
                        get_int("event_tick", 0) > 0;
            }
            clear(&payload);
        }
        wait_a_frame();
    }
    CHECK(heard);
}

int main(int argc, char** argv) {
    GDExtensionInitialization extension;
    GDExtensionBool (*begin)(
        GDExtensionInterfaceGetProcAddress, GDExtensionClassLibraryPtr, GDExtensionInitialization*);
    int level;
    void* const loaded = argc >= 3 ? dlopen(argv[1], RTLD_NOW) : NULL;
    CHECK(sizeof(variant) == 24);
    if (loaded == NULL) {
        fprintf(
            stderr, "%s\n", argc >= 3 ? dlerror() : "host EXTENSION.so PORT [--without FUNCTION]");
        return 2;
    }
    if (argc == 5) {
        without = argv[4];
    }
    *(void**)&begin = dlsym(loaded, "zoned_godot_init");
    CHECK(begin != NULL);
    memset(&extension, 0, sizeof extension);
    if (!begin(get_proc_address, kLibrary, &extension)) {
        return 3;
    }
    CHECK(extension.minimum_initialization_level == GDEXTENSION_INITIALIZATION_SCENE);
    for (level = 0; level < 4; ++level) {
        CHECK(classes == (level > GDEXTENSION_INITIALIZATION_SCENE));
        extension.initialize(extension.userdata, (GDExtensionInitializationLevel)level);
    }
    CHECK(live == 0);
    self = class_info.create_instance_func(class_info.class_userdata);
    before_it_is_connected();
    joins_and_walks(atoi(argv[2]));
    speaks_and_hears();
    call("quit", 0, NULL);
    CHECK(poll_now() == 4);
    class_info.free_instance_func(class_info.class_userdata, self->instance);
    free(self);
    for (level = 3; level >= 0; --level) {
        extension.deinitialize(extension.userdata, (GDExtensionInitializationLevel)level);
    }
    CHECK(classes == 0);
    printf("%zu methods, %d blocks of memory left\n", method_count, live);
    CHECK(live == 0);
    return 0;
}
