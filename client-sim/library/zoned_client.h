// zoned_client: joins a zoned server from any language: a C interface that is polled, without
// callbacks and without threads. Memory and sockets may be the game's own.
//
// The shape of a game loop:
//
//   zoned_client_settings settings = {.size = sizeof settings};
//   settings.name = "ann";
//   char error[256];
//   zoned_client* client = zoned_client_create(ZONED_CLIENT_ABI, &settings, error, sizeof error);
//   zoned_client_connect(client, "127.0.0.1", 7777);
//   each frame:
//     zoned_client_set_input(client, &input);
//     zoned_client_poll(client, seconds);
//     zoned_client_next_event(...) until it returns 0;
//     zoned_client_own(...), zoned_client_entities(...), and draw.
//   zoned_client_destroy(client);
//
// Structs grow at their end. Each begins with its size, which the caller sets: the library fills as
// much of it as both know. Of an array the first element's size counts.
//
// Frames: right-handed, y up, metres, seconds, radians. All positions are world coordinates, in
// double precision. Orientations are unit quaternions (x, y, z, w). A yaw of 0 looks along +z; it
// grows from +z towards +x.
//
// Ownership: the library never keeps a pointer of the caller beyond the call, but for functions and
// contexts of zoned_client_allocator and zoned_client_sockets. Texts that it returns are UTF-8 and
// good until the next call with the same client.
//
// Threads: a client is used by one thread at a time; different clients by different threads. A name
// that is no address is looked up on a thread of the library's own, so that no call waits for it;
// `no_threads` forbids it.
//
// Memory: all that a client holds comes from its allocator, and is given back at its destruction at
// the latest. Two libraries below take memory of their own: OpenSSL for TLS and sealed datagrams
// (CRYPTO_set_mem_functions() is the game's to call), and the C library for the lookup of a name.
// A client whose allocator gives nothing is closed for good: it gives all back but itself, its
// trouble is "out of memory", and calls return ZONED_CLIENT_FAILED or 0.
//
// Errors: a function that returns int returns one of zoned_client_result where it is negative. No
// exception leaves the library or may enter it, and no server can make it abort.
#pragma once

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#define ZONED_CLIENT_API __attribute__((visibility("default")))
#else
#define ZONED_CLIENT_API
#endif

/* The interface that this header describes: another major number is another interface, a greater
   minor number knows more functions and longer structs. */
#define ZONED_CLIENT_ABI_MAJOR 1
#define ZONED_CLIENT_ABI_MINOR 5
#define ZONED_CLIENT_ABI ((uint32_t)(ZONED_CLIENT_ABI_MAJOR << 16 | ZONED_CLIENT_ABI_MINOR))

/* Room for a name with its closing 0; longer names are cut. */
#define ZONED_CLIENT_NAME_BYTES 64
#define ZONED_CLIENT_MOST_SIGHTS 8

typedef struct zoned_client zoned_client;

enum zoned_client_result {
    ZONED_CLIENT_BAD_ARGUMENT = -1, /* a null pointer, a size of 0, an index beyond the last */
    ZONED_CLIENT_NOT_READY = -2, /* needs the world, or an avatar, that a server has not sent yet */
    ZONED_CLIENT_TOO_SMALL = -3, /* the caller's buffer; nothing is lost, ask again */
    ZONED_CLIENT_FAILED = -4     /* zoned_client_trouble() says why */
};

enum zoned_client_state {
    ZONED_CLIENT_IDLE = 0,       /* connect() was not called */
    ZONED_CLIENT_CONNECTING = 1, /* waiting for the address, the stream or the login */
    ZONED_CLIENT_ONLINE = 2,
    ZONED_CLIENT_WAITING = 3, /* the stream was lost; tries again by itself, and resumes */
    ZONED_CLIENT_CLOSED =
        4 /* for good: quit, refused, closed or unreachable; connect() begins anew */
};

enum zoned_client_trust {
    ZONED_CLIENT_TRUST_DEFAULT = 0, /* anyone on an address of this machine, else (and by a game's
                                       own sockets) authorities */
    ZONED_CLIENT_TRUST_PIN = 1,     /* the certificate whose SHA-256 is `pin` */
    ZONED_CLIENT_TRUST_ANYONE = 2,  /* for development */
    ZONED_CLIENT_TRUST_AUTHORITIES = 3 /* chain and host name, against `ca_file` or the system's */
};

enum zoned_client_view {
    ZONED_CLIENT_EXTRAPOLATE = 0, /* shows the server's present by prediction */
    ZONED_CLIENT_INTERPOLATE = 1  /* shows the past whose news has come: smoother, and later */
};

/* Since 1.3: the memory of a client. The functions are called by the thread that uses the client,
   from within its calls alone, and must not call the library. A client keeps blocks that it has
   freed for its next ones: after some seconds a frame calls neither. */
typedef struct zoned_client_allocator {
    uint32_t size;
    uint32_t reserved;
    void* context;
    void* (*allocate)(void* context, size_t size); /* aligned to 16 bytes; null: there is none */
    void (*release)(void* context, void* block);
} zoned_client_allocator;

enum zoned_client_socket_kind {
    ZONED_CLIENT_STREAM = 0,   /* as TCP; the library brings TLS */
    ZONED_CLIENT_DATAGRAMS = 1 /* as UDP, to one host; sealed by the library, at most 1200 bytes */
};

enum zoned_client_socket_result {
    ZONED_CLIENT_SOCKET_ENDED = -1, /* the server has closed the stream in order */
    ZONED_CLIENT_SOCKET_FAILED = -2 /* it is lost; the client tries again with a new one */
};

/* Since 1.3: sockets of the game. No function may wait, nor call the library. */
typedef struct zoned_client_sockets {
    uint32_t size;
    uint32_t reserved;
    void* context;
    /* Begins to connect to a name or an address. Returns a number >= 0 of the game's choice that
       names the socket; below 0: there is none. Without one for datagrams states travel inside the
       stream. */
    int (*open)(void* context, int kind, const char* host, uint16_t port);
    /* Returns the bytes that were taken, 0 when none are now (as before it is connected), or one of
       zoned_client_socket_result. Of datagrams one is sent whole. */
    int64_t (*send)(void* context, int socket, const void* bytes, size_t size);
    /* The same for bytes that have come. Of datagrams one is received whole. */
    int64_t (*receive)(void* context, int socket, void* bytes, size_t capacity);
    void (*close)(void* context, int socket);
} zoned_client_sockets;

/* Texts may be null: empty. */
typedef struct zoned_client_settings {
    uint32_t size;
    uint32_t view;             /* zoned_client_view */
    const char* name;          /* shown to others, 1..32 bytes; a ticket's name wins */
    const char* team;          /* may be empty */
    const void* ticket;        /* bytes of a login ticket; null where the server lets anyone in */
    size_t ticket_size;        /* bytes */
    const char* config_digest; /* hex; empty: any config of the server */
    uint32_t trust;            /* zoned_client_trust */
    uint32_t measure;          /* since 1.1: 1: asks for the truth, where it may, and compares */
    const char* pin;           /* 64 hex digits, for ZONED_CLIENT_TRUST_PIN */
    const char* ca_file;       /* empty: the system's authorities */
    const char* world;         /* of a cluster; empty: the server's. Redirects are followed */
    /* Since 1.3. */
    const zoned_client_allocator* allocator; /* null: malloc() and free() */
    const zoned_client_sockets* sockets;     /* null: those of the system */
    const char* server_name; /* in the server's certificate; empty: the host of connect() */
    uint32_t no_threads;     /* 1: no name is looked up; connect() wants an address */
    uint32_t reserved;
} zoned_client_settings;

/* What the avatar is to do from now on, until the next one. */
typedef struct zoned_client_input {
    uint32_t size;
    uint32_t
        buttons;  /* bit 0 jump, bit 1 sprint, 4..15 of the game. A press counts, however short */
    float move_x; /* wanted direction along world x and z, -1..1 of full speed; longer is cut */
    float move_z;
    float yaw;   /* where it looks, rad */
    float pitch; /* up is positive, -pi/2..pi/2 */
} zoned_client_input;

typedef struct zoned_client_entity {
    uint32_t size;
    uint32_t id;   /* not 0 */
    uint32_t type; /* for zoned_client_type() */
    uint32_t zone; /* id of the zone that owns it */
    double position[3];
    float orientation[4];
    float velocity[3];   /* m/s, of the displayed motion */
    uint32_t appearance; /* 16 bits of the game's rules */
    uint32_t at_rest;    /* 1: it does not move */
    uint32_t reserved;
} zoned_client_entity;

/* The own avatar, as predicted from the own input. */
typedef struct zoned_client_avatar {
    uint32_t size;
    uint32_t id;
    uint32_t zone;
    uint32_t grounded; /* 1: stands on something */
    uint32_t carried;  /* 1: rides on something, which moves it, or is hidden and stands */
    float yaw;         /* rad */
    double position[3];
    double eye[3]; /* where it looks from */
    float velocity[3];
    uint32_t reserved;
    int64_t tick; /* since 1.1: of its newest command */
} zoned_client_avatar;

typedef struct zoned_client_event {
    uint32_t size;
    uint32_t kind; /* up to 15 the server's own (proto/session.proto), from 16 on the game's */
    int64_t tick;  /* when it happened */
    uint64_t id;   /* the same for all that hear of it */
    size_t payload_size;                 /* bytes */
    uint32_t history;                    /* 1: happened before this client listened to its topic */
    char topic[ZONED_CLIENT_NAME_BYTES]; /* empty: for this client alone */
    uint32_t reserved;
} zoned_client_event;

typedef struct zoned_client_world {
    uint32_t size;
    uint32_t types;     /* how many; indices go from 0 */
    uint32_t zones;     /* how many; indices go from 0 */
    uint32_t rights;    /* bits: 1 play, 2 audit, 4 freeze, 8 admin */
    double tick_s;      /* length of a tick */
    double server_time; /* s, of the server's clock; 0 before it is known */
    int64_t tick;       /* displayed tick of the server; times tick_s it is the time shown */
} zoned_client_world;

typedef struct zoned_client_type_info {
    uint32_t size;
    uint32_t upright;   /* 1: turns about y only */
    uint32_t character; /* 1: the following holds */
    uint32_t seats;     /* characters that may ride on it */
    float radius;       /* of the upright capsule, m */
    float half_segment; /* half the distance between the centres of its two ends, m */
    float speed;        /* walking, m/s */
    float sprint_factor;
    float jump_speed; /* m/s */
    float gravity;    /* m/s2, downwards */
    char name[ZONED_CLIENT_NAME_BYTES];
} zoned_client_type_info;

typedef struct zoned_client_zone_info {
    uint32_t size;
    uint32_t id;
    double lower[2]; /* x and z of its region */
    double upper[2];
    double ground_height;
    uint32_t boxes;     /* for zoned_client_boxes() */
    uint32_t triangles; /* for zoned_client_triangles() */
} zoned_client_zone_info;

/* A solid box of the world. */
typedef struct zoned_client_box {
    uint32_t size;
    uint32_t door; /* 1: it is one, and there while `shut` */
    double centre[3];
    float half_extents[3];
    float orientation[4];
    uint32_t shut;     /* 1: solid at the displayed tick; always for boxes that are no doors */
    uint32_t platform; /* Since 1.4. 1: it travels, and is where the own avatar finds it */
} zoned_client_box;

/* Since 1.2: the fields that a game declares for a type (`field { ... }` of its config). */
enum zoned_client_field_kind {
    ZONED_CLIENT_FIELD_NUMBER = 0,
    ZONED_CLIENT_FIELD_ENUM = 1,
    ZONED_CLIENT_FIELD_BOOL = 2,
    ZONED_CLIENT_FIELD_TEXT = 3
};

typedef struct zoned_client_field_info {
    uint32_t size;
    uint32_t kind;   /* zoned_client_field_kind */
    double minimum;  /* of a number ... */
    double maximum;  /* ... and its greatest value */
    double quantum;  /* between two of its values */
    uint32_t values; /* how many an enum has */
    uint32_t reserved;
    char name[ZONED_CLIENT_NAME_BYTES];
} zoned_client_field_info;

typedef struct zoned_client_field_value {
    uint32_t size;
    uint32_t kind; /* zoned_client_field_kind */
    double number; /* a number; the index of an enum's value; 0 or 1 of a bool */
    char text[ZONED_CLIENT_NAME_BYTES]; /* a text, or the name of an enum's value */
} zoned_client_field_value;

typedef struct zoned_client_sight {
    uint32_t entity;
    uint32_t reserved;
    int64_t publication; /* tick of the news from which it is displayed */
    double position[3];
} zoned_client_sight;

/* The characters displayed along a ray: what a server needs to judge a shot by what was seen. */
typedef struct zoned_client_aim_info {
    uint32_t size;
    uint32_t past;   /* 1: an interpolating view */
    int64_t tick;    /* displayed tick of the others */
    double fraction; /* of the tick after it, [0, 1) */
    uint32_t hit;    /* entity; 0: none */
    uint32_t sights; /* how many of `sight` are filled, nearest to the ray first */
    double distance; /* to the hit, m */
    zoned_client_sight sight[ZONED_CLIENT_MOST_SIGHTS];
} zoned_client_aim_info;

/* A particle of smoke, rain or sparks, which no server sends: a function of seed and time. */
typedef struct zoned_client_particle {
    uint32_t size;
    float age; /* 0 at birth, 1 at the end */
    double position[3];
    float velocity[3];
    uint32_t reserved;
} zoned_client_particle;

typedef struct zoned_client_stats_info {
    uint32_t size;
    uint32_t tunnelled; /* 1: states had to travel inside the stream, at least for a time */
    double rtt_ms;
    double input_lead_ms; /* by which commands are made ahead of the server's clock */
    uint64_t packets_in;
    uint64_t packets_out;
    uint64_t bytes_in; /* of datagrams and frames */
    uint64_t bytes_out;
    uint64_t malformed; /* frames and datagrams that could not be read or did not authenticate */
    uint64_t resumed;   /* times that the session came back after a lost stream */
    uint64_t inputs;    /* ticks on whose command the server has reported */
    uint64_t inputs_missing; /* of these: the command was too late */
    uint64_t events_dropped; /* because nobody fetched them */
    /* Since 1.1: by how much the server corrected what was predicted of the own avatar, over the
       newest 512 comparisons. */
    uint64_t corrections; /* comparisons in all */
    double correction_last_m;
    double correction_p99_m;
    double correction_max_m;
    /* With `measure`, over as many: displayed and true places of others, and of the own avatar. */
    uint64_t compared; /* entities in all */
    double displayed_error_p50_m;
    double displayed_error_p99_m;
    double own_error_p99_m;
} zoned_client_stats_info;

/* The interface of the library, as ZONED_CLIENT_ABI is that of the header. */
ZONED_CLIENT_API uint32_t zoned_client_abi_version(void);

/* `abi` is ZONED_CLIENT_ABI of the header that the caller was built with. Null on failure, with the
   reason in `error` (may be null): another major version, a bad setting, no memory. */
ZONED_CLIENT_API zoned_client* zoned_client_create(uint32_t abi,
                                                   const zoned_client_settings* settings,
                                                   char* error,
                                                   size_t error_capacity);
/* Says goodbye where it is online. Null does nothing. */
ZONED_CLIENT_API void zoned_client_destroy(zoned_client* client);

/* Begins to connect and returns at once, 0 on success; poll() goes on. `host` is a name or an
   address of IPv4 or IPv6. Only for clients that are idle or closed. */
ZONED_CLIENT_API int zoned_client_connect(zoned_client* client, const char* host, uint16_t port);
/* Since 1.1, in place of connect(): the session goes over a WebSocket that the caller owns (a
   browser's), with the subprotocol "zoned". 0 on success. After each poll() the caller does what
   zoned_client_stream_wish() says, and sends each frame of zoned_client_next_frame() as one binary
   message. It tells the client what happens to the WebSocket by the three functions below. */
ZONED_CLIENT_API int zoned_client_begin(zoned_client* client);

enum zoned_client_wish {
    ZONED_CLIENT_WISH_NOTHING = 0,
    ZONED_CLIENT_WISH_OPEN = 1, /* a new WebSocket; one that is left is closed without a word */
    ZONED_CLIENT_WISH_CLOSE = 2 /* after the frames that wait */
};

/* One of zoned_client_wish; each wish is told once. */
ZONED_CLIENT_API int zoned_client_stream_wish(zoned_client* client);
/* The WebSocket that was wished for is open; a message came; it is closed, or could not be opened.
 */
ZONED_CLIENT_API int zoned_client_stream_opened(zoned_client* client);
ZONED_CLIENT_API int zoned_client_stream_frame(zoned_client* client,
                                               const void* frame,
                                               size_t size);
ZONED_CLIENT_API int zoned_client_stream_closed(zoned_client* client, const char* reason);
/* Size of the oldest frame to send, which is taken where `capacity` suffices; 0: none waits. */
ZONED_CLIENT_API size_t zoned_client_next_frame(zoned_client* client, void* out, size_t capacity);

/* Says goodbye; closed from then on. */
ZONED_CLIENT_API void zoned_client_quit(zoned_client* client);

/* All work of a frame: receives, advances the view, sends the commands that are due. `now_s` is any
   clock of the caller that does not go back, in s. Call it at least 20 times a second, better each
   frame. Never waits. Returns the state. */
ZONED_CLIENT_API int zoned_client_poll(zoned_client* client, double now_s);

/* One of zoned_client_state. */
ZONED_CLIENT_API int zoned_client_get_state(const zoned_client* client);
/* Why the client is closed, waiting or has failed, in one line; empty when all is well. */
ZONED_CLIENT_API const char* zoned_client_trouble(const zoned_client* client);

/* 0 on success. Holds until the next one. */
ZONED_CLIENT_API int zoned_client_set_input(zoned_client* client, const zoned_client_input* input);
/* A reliable command of the game, carried out once and in order; also across lost streams. 0 on
   success, ZONED_CLIENT_NOT_READY before the first login or with 1,024 unacknowledged. */
ZONED_CLIENT_API int zoned_client_command(zoned_client* client,
                                          uint32_t kind,
                                          const void* payload,
                                          size_t payload_size);
/* 1: an event, 0: none is left. Events come exactly once and in order. With ZONED_CLIENT_TOO_SMALL
   `event->payload_size` says how much room it wants, and the event stays the next. */
ZONED_CLIENT_API int zoned_client_next_event(zoned_client* client,
                                             zoned_client_event* event,
                                             void* payload,
                                             size_t payload_capacity);

/* The entities displayed now, by ascending id and without the own avatar; returns how many there
   are, and fills at most `capacity` of them. Allocates nothing. */
ZONED_CLIENT_API size_t zoned_client_entities(const zoned_client* client,
                                              zoned_client_entity* out,
                                              size_t capacity);
/* 1: filled, 0: not displayed. */
ZONED_CLIENT_API int zoned_client_get_entity(const zoned_client* client,
                                             uint32_t id,
                                             zoned_client_entity* out);
/* Since 1.2: how many fields a type declares; indices go from 0. ZONED_CLIENT_BAD_ARGUMENT where
   there is no such type. */
ZONED_CLIENT_API int zoned_client_fields(const zoned_client* client, uint32_t type);
/* Since 1.2: 0 on success. */
ZONED_CLIENT_API int zoned_client_field(const zoned_client* client,
                                        uint32_t type,
                                        uint32_t index,
                                        zoned_client_field_info* out);
/* Since 1.2: the value of a field of an entity that the client knows, and of the own avatar; it is
   the newest that came, whatever moment the view shows. 1: filled, 0: the entity is not known or
   its type has no such field. */
ZONED_CLIENT_API int zoned_client_field_at(const zoned_client* client,
                                           uint32_t entity,
                                           uint32_t index,
                                           zoned_client_field_value* out);
/* Since 1.2: the same by the field's name. */
ZONED_CLIENT_API int zoned_client_field_named(const zoned_client* client,
                                              uint32_t entity,
                                              const char* name,
                                              zoned_client_field_value* out);
/* Since 1.5: deforms `count` places of three floats each, which lie on the undeformed soft body
   about its centre of mass, as the body is deformed now; the entity's pose is applied to what comes
   out. Any mesh will do that fills the same box. 1: done, 0: nothing changed, as the entity is not
   known or clients hear of no deformation of its type. */
ZONED_CLIENT_API int zoned_client_deform(const zoned_client* client,
                                         uint32_t entity,
                                         float* places,
                                         size_t count);
/* 1: filled, 0: there is no avatar yet. */
ZONED_CLIENT_API int zoned_client_own(const zoned_client* client, zoned_client_avatar* out);

/* The following return 0 on success. */
ZONED_CLIENT_API int zoned_client_get_world(const zoned_client* client, zoned_client_world* out);
ZONED_CLIENT_API int zoned_client_type(const zoned_client* client,
                                       uint32_t index,
                                       zoned_client_type_info* out);
ZONED_CLIENT_API int zoned_client_zone(const zoned_client* client,
                                       uint32_t index,
                                       zoned_client_zone_info* out);
/* `direction` need not be of unit length; `range` in m. Only flat ground hides. */
ZONED_CLIENT_API int zoned_client_aim(const zoned_client* client,
                                      const double eye[3],
                                      const double direction[3],
                                      double range,
                                      zoned_client_aim_info* out);
ZONED_CLIENT_API int zoned_client_stats(const zoned_client* client, zoned_client_stats_info* out);
/* The present value of a clock or variable that all sides share ("time_of_day", "weather"). */
ZONED_CLIENT_API int zoned_client_shared_value(const zoned_client* client,
                                               const char* name,
                                               double* out);

/* The server's clock now, s; 0 before it is known. */
ZONED_CLIENT_API double zoned_client_server_time(const zoned_client* client);

/* The static world around a zone; return how many there are, and fill at most `capacity`. A
   triangle is nine numbers, its corners counter-clockwise seen from the front. */
ZONED_CLIENT_API size_t zoned_client_boxes(const zoned_client* client,
                                           uint32_t zone_index,
                                           zoned_client_box* out,
                                           size_t capacity);
ZONED_CLIENT_API size_t zoned_client_triangles(const zoned_client* client,
                                               uint32_t zone_index,
                                               double* out,
                                               size_t capacity);
/* Cosmetic particles alive at the displayed tick; returns how many there are, and fills at most
   `capacity`. Costs time in proportion to all of them. */
ZONED_CLIENT_API size_t zoned_client_particles(const zoned_client* client,
                                               zoned_client_particle* out,
                                               size_t capacity);

#ifdef __cplusplus
}
#endif
