// ZonedClient: joins a zoned server from C#, in Unity, Godot or plain .NET, by P/Invoke.
// A thin layer over libzoned_client; zoned_client.h says what each field means, in which unit and
// frame. Nothing here allocates in a frame, but for events.
using System;
using System.Runtime.InteropServices;
using System.Text;

namespace Zoned
{
    public enum ClientState { Idle = 0, Connecting = 1, Online = 2, Waiting = 3, Closed = 4 }

    public enum Trust { Default = 0, Pin = 1, Anyone = 2, Authorities = 3 }

    public enum ViewKind { Extrapolate = 0, Interpolate = 1 }

    /// Memory of the game's own, by functions of C (zoned_client.h).
    [StructLayout(LayoutKind.Sequential)]
    public struct Allocator { internal uint Size, Reserved; public IntPtr Context, Allocate, Release; }

    /// Sockets of the game's own, by functions of C (zoned_client.h).
    [StructLayout(LayoutKind.Sequential)]
    public struct Sockets { internal uint Size, Reserved; public IntPtr Context, Open, Send, Receive, Close; }

    public class ZonedException : Exception
    {
        public ZonedException(string text) : base(text) { }
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Vector { public double X, Y, Z; }

    [StructLayout(LayoutKind.Sequential)]
    public struct VectorF { public float X, Y, Z; }

    [StructLayout(LayoutKind.Sequential)]
    public struct Turn { public float X, Y, Z, W; }

    [StructLayout(LayoutKind.Sequential)]
    public struct Input
    {
        internal uint Size;
        public uint Buttons;
        public float MoveX, MoveZ, Yaw, Pitch;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Entity
    {
        internal uint Size;
        public uint Id, Type, Zone;
        public Vector Position;
        public Turn Orientation;
        public VectorF Velocity;
        public uint Appearance, AtRest, Reserved;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Avatar
    {
        internal uint Size;
        public uint Id, Zone, Grounded, Carried;
        public float Yaw;
        public Vector Position, Eye;
        public VectorF Velocity;
        public uint Reserved;
        public long Tick;
    }

    [StructLayout(LayoutKind.Sequential, CharSet = CharSet.Ansi)]
    public struct EventInfo
    {
        internal uint Size;
        public uint Kind;
        public long Tick;
        public ulong Id;
        public UIntPtr PayloadSize;
        public uint History;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 64)]
        internal byte[] TopicBytes;
        public uint Reserved;

        public string Topic { get { return Native.Text(TopicBytes); } }
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct TypeInfo
    {
        internal uint Size;
        public uint Upright, Character, Seats;
        public float Radius, HalfSegment, Speed, SprintFactor, JumpSpeed, Gravity;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 64)]
        internal byte[] NameBytes;

        public string Name { get { return Native.Text(NameBytes); } }
    }

    public enum FieldKind { Number = 0, Enum = 1, Bool = 2, Text = 3 }

    /// A field that a game declares for a type.
    [StructLayout(LayoutKind.Sequential)]
    public struct FieldInfo
    {
        internal uint Size;
        public FieldKind Kind;
        public double Minimum, Maximum, Quantum;
        public uint Values, Reserved;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 64)]
        internal byte[] NameBytes;

        public string Name { get { return Native.Text(NameBytes); } }
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct FieldValue
    {
        internal uint Size;
        public FieldKind Kind;
        public double Number; // a number, the index of an enum's value, 0 or 1 of a bool
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 64)]
        internal byte[] TextBytes;

        /// A text, or the name of an enum's value.
        public string Text { get { return Native.Text(TextBytes); } }
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct World
    {
        internal uint Size;
        public uint Types, Zones, Rights;
        public double TickSeconds, ServerTime;
        public long Tick;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct ZoneInfo
    {
        internal uint Size;
        public uint Id;
        public double LowerX, LowerZ, UpperX, UpperZ, GroundHeight;
        public uint Boxes, Triangles;
    }

    /// A solid box of the world.
    [StructLayout(LayoutKind.Sequential)]
    public struct Box
    {
        internal uint Size;
        public uint Door;
        public Vector Centre;
        public VectorF HalfExtents;
        public Turn Orientation;
        public uint Shut, Platform;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Sight
    {
        public uint Entity, Reserved;
        public long Publication;
        public Vector Position;
    }

    /// The characters along a ray: aim[0] to aim[Sights - 1], the nearest to the ray first.
    [StructLayout(LayoutKind.Sequential)]
    public struct Aim
    {
        internal uint Size;
        public uint Past;
        public long Tick;
        public double Fraction;
        public uint Hit, Sights;
        public double Distance;
        private Sight s0, s1, s2, s3, s4, s5, s6, s7;

        public Sight this[int index]
        {
            get
            {
                switch (index)
                {
                    case 0: return s0;
                    case 1: return s1;
                    case 2: return s2;
                    case 3: return s3;
                    case 4: return s4;
                    case 5: return s5;
                    case 6: return s6;
                    case 7: return s7;
                    default: throw new IndexOutOfRangeException();
                }
            }
        }
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Particle
    {
        internal uint Size;
        public float Age;
        public Vector Position;
        public VectorF Velocity;
        public uint Reserved;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Stats
    {
        internal uint Size;
        public uint Tunnelled;
        public double RttMs, InputLeadMs;
        public ulong PacketsIn, PacketsOut, BytesIn, BytesOut, Malformed, Resumed, Inputs, InputsMissing, EventsDropped, Corrections;
        public double CorrectionLastM, CorrectionP99M, CorrectionMaxM;
        public ulong Compared;
        public double DisplayedErrorP50M, DisplayedErrorP99M, OwnErrorP99M;
    }

    /// For sessions over a WebSocket of the caller.
    public enum StreamWish { Nothing = 0, Open = 1, Close = 2 }

    internal static class Native
    {
        internal const uint Abi = 1 << 16 | 4; // of zoned_client.h
        internal const int TooSmall = -3;
        private const string Library = "zoned_client";

        [StructLayout(LayoutKind.Sequential)]
        internal struct Settings
        {
            public uint Size, View;
            public IntPtr Name, Team, Ticket;
            public UIntPtr TicketSize;
            public IntPtr ConfigDigest;
            public uint Trust, Measure;
            public IntPtr Pin, CaFile, World;
            public IntPtr Allocator, Sockets, ServerName;
            public uint NoThreads, Reserved;
        }

        [DllImport(Library)]
        internal static extern IntPtr zoned_client_create(uint abi, ref Settings settings, byte[] error, UIntPtr capacity);
        [DllImport(Library)] internal static extern void zoned_client_destroy(IntPtr client);
        [DllImport(Library)] internal static extern int zoned_client_connect(IntPtr client, byte[] host, ushort port);
        [DllImport(Library)] internal static extern void zoned_client_quit(IntPtr client);
        [DllImport(Library)] internal static extern int zoned_client_poll(IntPtr client, double now);
        [DllImport(Library)] internal static extern IntPtr zoned_client_trouble(IntPtr client);
        [DllImport(Library)] internal static extern int zoned_client_set_input(IntPtr client, ref Input input);
        [DllImport(Library)]
        internal static extern int zoned_client_command(IntPtr client, uint kind, byte[] payload, UIntPtr size);
        [DllImport(Library)]
        internal static extern int zoned_client_next_event(IntPtr client, ref EventInfo info, byte[] payload, UIntPtr capacity);
        [DllImport(Library)]
        internal static extern UIntPtr zoned_client_entities(IntPtr client, [In, Out] Entity[] entities, UIntPtr capacity);
        [DllImport(Library)] internal static extern int zoned_client_own(IntPtr client, ref Avatar avatar);
        [DllImport(Library)] internal static extern int zoned_client_get_world(IntPtr client, ref World world);
        [DllImport(Library)] internal static extern int zoned_client_type(IntPtr client, uint index, ref TypeInfo type);
        [DllImport(Library)] internal static extern int zoned_client_fields(IntPtr client, uint type);
        [DllImport(Library)]
        internal static extern int zoned_client_field(IntPtr client, uint type, uint index, ref FieldInfo info);
        [DllImport(Library)]
        internal static extern int zoned_client_field_at(IntPtr client, uint entity, uint index, ref FieldValue value);
        [DllImport(Library)]
        internal static extern int zoned_client_deform(IntPtr client, uint entity, [In, Out] float[] places, UIntPtr count);
        [DllImport(Library)]
        internal static extern int zoned_client_field_named(IntPtr client, uint entity, byte[] name, ref FieldValue value);

        [DllImport(Library)] internal static extern uint zoned_client_abi_version();
        [DllImport(Library)] internal static extern int zoned_client_begin(IntPtr client);
        [DllImport(Library)] internal static extern int zoned_client_stream_wish(IntPtr client);
        [DllImport(Library)] internal static extern int zoned_client_stream_opened(IntPtr client);
        [DllImport(Library)] internal static extern int zoned_client_stream_frame(IntPtr client, byte[] frame, UIntPtr size);
        [DllImport(Library)] internal static extern int zoned_client_stream_closed(IntPtr client, byte[] reason);
        [DllImport(Library)] internal static extern UIntPtr zoned_client_next_frame(IntPtr client, byte[] frame, UIntPtr capacity);
        [DllImport(Library)] internal static extern int zoned_client_get_state(IntPtr client);
        [DllImport(Library)] internal static extern int zoned_client_get_entity(IntPtr client, uint id, ref Entity entity);
        [DllImport(Library)] internal static extern int zoned_client_zone(IntPtr client, uint index, ref ZoneInfo zone);
        [DllImport(Library)]
        internal static extern int zoned_client_aim(IntPtr client, ref Vector eye, ref Vector direction, double range, ref Aim aim);
        [DllImport(Library)] internal static extern int zoned_client_stats(IntPtr client, ref Stats stats);
        [DllImport(Library)] internal static extern int zoned_client_shared_value(IntPtr client, byte[] name, out double value);
        [DllImport(Library)] internal static extern double zoned_client_server_time(IntPtr client);
        [DllImport(Library)]
        internal static extern UIntPtr zoned_client_boxes(IntPtr client, uint zone, [In, Out] Box[] boxes, UIntPtr capacity);
        [DllImport(Library)]
        internal static extern UIntPtr zoned_client_triangles(IntPtr client, uint zone, [In, Out] double[] corners, UIntPtr capacity);
        [DllImport(Library)]
        internal static extern UIntPtr zoned_client_particles(IntPtr client, [In, Out] Particle[] particles, UIntPtr capacity);

        /// Bytes with a closing 0.
        internal static byte[] Bytes(string text)
        {
            return Encoding.UTF8.GetBytes((text ?? "") + "\0");
        }

        internal static string Text(byte[] bytes)
        {
            int end = bytes == null ? -1 : Array.IndexOf(bytes, (byte)0);
            return end < 0 ? "" : Encoding.UTF8.GetString(bytes, 0, end);
        }

        internal static string Text(IntPtr text)
        {
            int size = 0;
            while (Marshal.ReadByte(text, size) != 0) { ++size; }
            byte[] bytes = new byte[size];
            Marshal.Copy(text, bytes, 0, size);
            return Encoding.UTF8.GetString(bytes);
        }

        internal static uint SizeOf<T>()
        {
            return (uint)Marshal.SizeOf(typeof(T));
        }
    }

    /// One session with a server. Not for several threads at a time.
    public sealed class Client : IDisposable
    {
        private IntPtr client;
        private Entity[] entities = new Entity[256];
        private byte[] payload = new byte[4096];

        public Client(string name, string team = "", byte[] ticket = null, Trust trust = Trust.Default,
                      string pin = "", string caFile = "", ViewKind view = ViewKind.Extrapolate, string world = "",
                      Allocator allocator = new Allocator(), Sockets sockets = new Sockets(), string serverName = "", bool threads = true)
        {
            allocator.Size = Native.SizeOf<Allocator>();
            sockets.Size = Native.SizeOf<Sockets>();
            GCHandle[] pins = Array.ConvertAll(
                new object[] { Native.Bytes(name), Native.Bytes(team), ticket ?? new byte[1], Native.Bytes(""), Native.Bytes(pin), Native.Bytes(caFile), Native.Bytes(world), allocator, sockets, Native.Bytes(serverName) },
                pinned => GCHandle.Alloc(pinned, GCHandleType.Pinned));
            try
            {
                Native.Settings settings = new Native.Settings
                {
                    Size = Native.SizeOf<Native.Settings>(),
                    View = (uint)view,
                    Name = pins[0].AddrOfPinnedObject(),
                    Team = pins[1].AddrOfPinnedObject(),
                    Ticket = pins[2].AddrOfPinnedObject(),
                    TicketSize = (UIntPtr)(ticket == null ? 0 : ticket.Length),
                    ConfigDigest = pins[3].AddrOfPinnedObject(),
                    Trust = (uint)trust,
                    Pin = pins[4].AddrOfPinnedObject(),
                    CaFile = pins[5].AddrOfPinnedObject(),
                    World = pins[6].AddrOfPinnedObject(),
                    Allocator = allocator.Allocate != IntPtr.Zero ? pins[7].AddrOfPinnedObject() : IntPtr.Zero,
                    Sockets = sockets.Open != IntPtr.Zero ? pins[8].AddrOfPinnedObject() : IntPtr.Zero,
                    ServerName = pins[9].AddrOfPinnedObject(),
                    NoThreads = threads ? 0u : 1u,
                };
                byte[] error = new byte[512];
                client = Native.zoned_client_create(Native.Abi, ref settings, error, (UIntPtr)error.Length);
                if (client == IntPtr.Zero) { throw new ZonedException(Native.Text(error)); }
            }
            finally
            {
                foreach (GCHandle pinned in pins) { pinned.Free(); }
            }
        }

        /// Says goodbye and frees the client.
        public void Dispose()
        {
            Native.zoned_client_destroy(client);
            client = IntPtr.Zero;
        }

        public void Connect(string host, ushort port)
        {
            Check(Native.zoned_client_connect(client, Native.Bytes(host), port));
        }

        public void Quit() { Native.zoned_client_quit(client); }

        public ClientState Poll(double nowSeconds)
        {
            return (ClientState)Native.zoned_client_poll(client, nowSeconds);
        }

        public string Trouble { get { return Native.Text(Native.zoned_client_trouble(client)); } }

        public void SetInput(Input input)
        {
            input.Size = Native.SizeOf<Input>();
            Check(Native.zoned_client_set_input(client, ref input));
        }

        public void Command(uint kind, byte[] bytes)
        {
            Check(Native.zoned_client_command(client, kind, bytes, (UIntPtr)bytes.Length));
        }

        /// The next event and its payload; false: none is left.
        public bool NextEvent(out EventInfo info, out byte[] bytes)
        {
            info = new EventInfo { Size = Native.SizeOf<EventInfo>() };
            int got = Native.zoned_client_next_event(client, ref info, payload, (UIntPtr)payload.Length);
            if (got == Native.TooSmall)
            {
                payload = new byte[(int)info.PayloadSize];
                got = Native.zoned_client_next_event(client, ref info, payload, (UIntPtr)payload.Length);
            }
            bytes = new byte[Check(got) == 1 ? (int)info.PayloadSize : 0];
            Array.Copy(payload, bytes, bytes.Length);
            return got == 1;
        }

        /// The displayed entities; the array is used again by the next call.
        public Entity[] Entities(out int count)
        {
            entities[0].Size = Native.SizeOf<Entity>();
            count = (int)Native.zoned_client_entities(client, entities, (UIntPtr)entities.Length);
            if (count > entities.Length)
            {
                entities = new Entity[2 * count];
                return Entities(out count);
            }
            return entities;
        }

        /// False while there is no avatar.
        public bool Own(out Avatar avatar)
        {
            avatar = new Avatar { Size = Native.SizeOf<Avatar>() };
            return Native.zoned_client_own(client, ref avatar) == 1;
        }

        public World World()
        {
            World world = new World { Size = Native.SizeOf<World>() };
            Check(Native.zoned_client_get_world(client, ref world));
            return world;
        }

        public TypeInfo Type(uint index)
        {
            TypeInfo type = new TypeInfo { Size = Native.SizeOf<TypeInfo>() };
            Check(Native.zoned_client_type(client, index, ref type));
            return type;
        }

        /// How many fields a type declares.
        public int Fields(uint type) { return Check(Native.zoned_client_fields(client, type)); }

        public FieldInfo Field(uint type, uint index)
        {
            FieldInfo info = new FieldInfo { Size = Native.SizeOf<FieldInfo>() };
            Check(Native.zoned_client_field(client, type, index, ref info));
            return info;
        }

        /// The newest value of a field; false: the entity is not known, or has no such field.
        public bool Field(uint entity, uint index, out FieldValue value)
        {
            value = new FieldValue { Size = Native.SizeOf<FieldValue>() };
            return Check(Native.zoned_client_field_at(client, entity, index, ref value)) == 1;
        }

        public bool Field(uint entity, string name, out FieldValue value)
        {
            value = new FieldValue { Size = Native.SizeOf<FieldValue>() };
            return Check(Native.zoned_client_field_named(client, entity, Native.Bytes(name), ref value)) == 1;
        }

        /// Deforms places on the undeformed soft body, three numbers each, as it is deformed now; the entity's pose is applied to them
        /// afterwards. False, and nothing changes, where the entity is not known or has no deformation.
        public bool Deform(uint entity, float[] places)
        {
            return Check(Native.zoned_client_deform(client, entity, places, (UIntPtr)(places.Length / 3))) == 1;
        }

        /// ABI of the loaded library: the major version times 65536, and the minor one.
        public static uint AbiVersion { get { return Native.zoned_client_abi_version(); } }

        public ClientState State { get { return (ClientState)Native.zoned_client_get_state(client); } }

        /// The server's clock, s; 0 before it is known.
        public double ServerTime { get { return Native.zoned_client_server_time(client); } }

        /// False where it is not displayed.
        public bool Entity(uint id, out Entity entity)
        {
            entity = new Entity { Size = Native.SizeOf<Entity>() };
            return Check(Native.zoned_client_get_entity(client, id, ref entity)) == 1;
        }

        public ZoneInfo Zone(uint index)
        {
            ZoneInfo zone = new ZoneInfo { Size = Native.SizeOf<ZoneInfo>() };
            Check(Native.zoned_client_zone(client, index, ref zone));
            return zone;
        }

        public Aim Aim(Vector eye, Vector direction, double range)
        {
            Aim aim = new Aim { Size = Native.SizeOf<Aim>() };
            Check(Native.zoned_client_aim(client, ref eye, ref direction, range, ref aim));
            return aim;
        }

        public Stats Stats()
        {
            Stats stats = new Stats { Size = Native.SizeOf<Stats>() };
            Check(Native.zoned_client_stats(client, ref stats));
            return stats;
        }

        public double SharedValue(string name)
        {
            double value;
            Check(Native.zoned_client_shared_value(client, Native.Bytes(name), out value));
            return value;
        }

        /// The static boxes around a zone. Allocates, like the next two: for loading, not for frames.
        public Box[] Boxes(uint zone)
        {
            Box[] boxes = new Box[(int)Native.zoned_client_boxes(client, zone, null, UIntPtr.Zero)];
            if (boxes.Length > 0)
            {
                boxes[0].Size = Native.SizeOf<Box>();
                Native.zoned_client_boxes(client, zone, boxes, (UIntPtr)boxes.Length);
            }
            return boxes;
        }

        /// Nine numbers for each triangle.
        public double[] Triangles(uint zone)
        {
            int count = (int)Native.zoned_client_triangles(client, zone, null, UIntPtr.Zero);
            double[] corners = new double[9 * count];
            Native.zoned_client_triangles(client, zone, corners, (UIntPtr)count);
            return corners;
        }

        public Particle[] Particles()
        {
            Particle[] particles = new Particle[(int)Native.zoned_client_particles(client, null, UIntPtr.Zero)];
            if (particles.Length > 0)
            {
                particles[0].Size = Native.SizeOf<Particle>();
                Native.zoned_client_particles(client, particles, (UIntPtr)particles.Length);
            }
            return particles;
        }

        /// In place of Connect(): the session goes over a WebSocket of the caller.
        public void Begin() { Check(Native.zoned_client_begin(client)); }

        public StreamWish StreamWish() { return (StreamWish)Check(Native.zoned_client_stream_wish(client)); }

        public void StreamOpened() { Check(Native.zoned_client_stream_opened(client)); }

        public void StreamFrame(byte[] frame, int size)
        {
            Check(Native.zoned_client_stream_frame(client, frame, (UIntPtr)size));
        }

        public void StreamClosed(string reason)
        {
            Check(Native.zoned_client_stream_closed(client, Native.Bytes(reason)));
        }

        /// The oldest frame to send as one binary message; null: none waits.
        public byte[] NextFrame()
        {
            int size = (int)Native.zoned_client_next_frame(client, null, UIntPtr.Zero);
            if (size == 0) { return null; }
            byte[] frame = new byte[size];
            Native.zoned_client_next_frame(client, frame, (UIntPtr)size);
            return frame;
        }

        private int Check(int result)
        {
            if (result < 0)
            {
                string trouble = Trouble;
                throw new ZonedException(trouble != "" ? trouble : "refused with " + result);
            }
            return result;
        }
    }
}
