export declare const IDLE = 0;
export declare const CONNECTING = 1;
export declare const ONLINE = 2;
/** The connection was lost; the client tries again by itself, and resumes. */
export declare const WAITING = 3;
/** For good: `trouble` says why. */
export declare const CLOSED = 4;
export declare type State = typeof IDLE | typeof CONNECTING | typeof ONLINE | typeof WAITING | typeof CLOSED;
/** Bits of Input.buttons; 4 to 15 are the game's. */
export declare const JUMP = 1;
export declare const SPRINT = 2;
/** Right-handed, y up, m: world coordinates. */
export declare type Vector = [x: number, y: number, z: number];
export declare type Quaternion = [x: number, y: number, z: number, w: number];
export interface Settings {
    /** Shown to others, 1 to 32 bytes; a ticket's name wins. */
    name: string;
    team?: string;
    /** A login ticket's bytes; none where the server lets anyone in. */
    ticket?: Uint8Array;
    /** 0: the server's present, predicted; 1: smooth, a little late. */
    view?: 0 | 1;
}
/** Wishes of the avatar from now on; those that are left out are 0. */
export interface Input {
    buttons?: number;
    /** Wanted direction along world x and z, -1 to 1 of full speed. */
    moveX?: number;
    moveZ?: number;
    /** Where it looks, rad: 0 along +z, growing towards +x. */
    yaw?: number;
    /** Up is positive. */
    pitch?: number;
}
/** Another entity as it is displayed now. */
export interface Entity {
    id: number;
    /** Index of types(). */
    type: number;
    zone: number;
    position: Vector;
    orientation: Quaternion;
    /** m/s */
    velocity: Vector;
    /** 16 bits of the game's rules. */
    appearance: number;
    atRest: boolean;
}
/** The own avatar, predicted from the own input. */
export interface Avatar {
    id: number;
    zone: number;
    grounded: boolean;
    /** It rides on something. */
    carried: boolean;
    yaw: number;
    position: Vector;
    eye: Vector;
    velocity: Vector;
    /** Of its newest command. */
    tick: number;
}
export interface GameEvent {
    /** Up to 15 the server's own, from 16 on the game's. */
    kind: number;
    tick: number;
    payload: Uint8Array;
}
export interface World {
    types: number;
    zones: number;
    rights: number;
    tickSeconds: number;
    serverTime: number;
    tick: number;
}
export interface TypeInfo {
    name: string;
    upright: boolean;
    character: boolean;
    /** Of a character's upright capsule, m. */
    radius: number;
    halfSegment: number;
    seats: number;
}
export interface ZoneInfo {
    id: number;
    min_x: number;
    min_z: number;
    max_x: number;
    max_z: number;
    ground: number;
    boxes: number;
    triangles: number;
}
export declare type FieldValue = number | string | boolean;
export interface FieldInfo {
    name: string;
    /** 0 number, 1 enum, 2 boolean, 3 text. */
    kind: number;
    minimum: number;
    maximum: number;
    quantum: number;
    /** How many an enum has. */
    values: number;
}
/** The sights along a ray, by which a server judges a shot. */
export interface Aim {
    past: boolean;
    tick: number;
    fraction: number;
    /** Entity; 0: none. */
    hit: number;
    sight: {
        entity: number;
        publication: number;
        place: Vector;
    }[];
}
export interface Stats {
    rttMs: number;
    leadMs: number;
    bytesIn: number;
    bytesOut: number;
    packetsIn: number;
    malformed: number;
    resumed: number;
    inputs: number;
    inputsMissing: number;
    /** How often the server compared the avatar's prediction, and by how much it was off. */
    corrections: number;
    correctionM: number;
    correctionM_p99: number;
    correctionM_max: number;
    /** With the right to audits: entities compared with the truth, and the error displayed. */
    audits: number;
    displayedM_p50: number;
    displayedM_p99: number;
    ownM_p99: number;
    judged: number;
    beyond: number;
    missing: number;
    extra: number;
    wrongValues: number;
    predictedM_max: number;
    verdict: string;
}
declare type Call = 'aim' | 'alloc' | 'boxes' | 'create' | 'entities' | 'error' | 'event' | 'field' | 'field_info' | 'free' | 'input' | 'judged' | 'name' | 'own' | 'rows' | 'stats' | 'type' | 'verdict' | 'world' | 'zone';
declare type LibraryCall = 'begin' | 'command' | 'deform' | 'get_state' | 'next_frame' | 'poll' | 'quit' | 'stream_closed' | 'stream_frame' | 'stream_opened' | 'stream_wish' | 'triangles' | 'trouble';
/** The compiled module, for as many clients as wanted. */
export declare type ClientModule = Record<`web_${Call}` | `zoned_client_${LibraryCall}`, (...numbers: number[]) => number> & {
    readonly memory: WebAssembly.Memory;
};
/** Compiles zoned_client.wasm: of a response, or of bytes. */
export declare function load(source: Response | BufferSource, complain?: (text: string) => void): Promise<ClientModule>;
/** One session. Each frame: input(), poll(), event() until there is none; then own() and entities(), and draw. */
export declare class WebClient {
    #private;
    /** null while there is no connection. */
    socket: WebSocket | null;
    /** Throws where settings are wrong. */
    constructor(code: ClientModule, { name, team, ticket, view }: Settings);
    /** Begins a session at a WebSocket's address; poll() goes on. */
    begin(url: string): void;
    /** All that is due; returns the state. */
    poll(): State;
    /** Says goodbye. */
    quit(): void;
    get state(): State;
    /** Why it is closed or waiting, in one line. */
    get trouble(): string;
    /** Holds until the next one. */
    input({ buttons, moveX, moveZ, yaw, pitch }: Input): void;
    /** A reliable command of the game; false: not now. */
    command(kind: number, payload: Uint8Array): boolean;
    /** The next event, once and in order, or null. */
    event(): GameEvent | null;
    /** null before there is an avatar. */
    own(): Avatar | null;
    /** The entities displayed now, by ascending id and without the own avatar. */
    entities(): Entity[];
    /** Value of an entity's declared field, by name or index; null: there is none. */
    field(entity: number, nameOrIndex: string | number): FieldValue | null;
    /** The fields that a type declares. */
    fields(type: number): FieldInfo[];
    /**
     * Deforms places on the undeformed soft body, three numbers each, as it is deformed now; the entity's pose is applied to them
     * afterwards. False, and nothing changes, where the entity is not known or has no deformation.
     */
    deform(entity: number, places: Float32Array): boolean;
    /** null before the server has described the world. */
    world(): World | null;
    types(): TypeInfo[];
    zones(): ZoneInfo[];
    /** Ten numbers for each solid box of a zone: walls (0), doors that are shut now (1), or platforms where they are now (2). */
    boxes(zone: number, kind: 0 | 1 | 2): Float32Array;
    /** Nine numbers for each triangle of a zone. */
    triangles(zone: number): Float32Array;
    /** The scene as it is displayed now, for the viewer's renderer; null before there is a world. */
    rows(ownType: number): ArrayBuffer | null;
    stats(): Stats | null;
    /** By the rules for bots: "consistent", or "inconsistent" with its reasons; empty: nothing was compared. */
    get verdict(): string;
    /** Characters along a ray, as a server must know them to judge a shot. */
    aim(eye: Vector, direction: Vector, range: number): Aim | null;
}
export {};
