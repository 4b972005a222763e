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

    public class ZonedException : Exception
    {
        public ZonedException(string text) : base(text) { }
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Vector
    {
        public double X, Y, Z;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct VectorF
    {
        public float X, Y, Z;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Turn
    {
        public float X, Y, Z, W;
    }

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

    internal static class Native
    {
        internal const uint Abi = 1 << 16 | 2; // of zoned_client.h
        internal const int TooSmall = -3;
        private const string Library = "zoned_client";

        [StructLayout(LayoutKind.Sequential)]
        internal struct Settings
        {
            public uint Size, View;
            public IntPtr Name, Team, Ticket;
            public UIntPtr TicketSize;
            public IntPtr ConfigDigest;
            public uint Trust, Reserved;
            public IntPtr Pin, CaFile;
        }

        [DllImport(Library)]
        internal static extern IntPtr zoned_client_create(uint abi, ref Settings settings, byte[] error, UIntPtr capacity);
        [DllImport(Library)]
        internal static extern void zoned_client_destroy(IntPtr client);
        [DllImport(Library)]
        internal static extern int zoned_client_connect(IntPtr client, byte[] host, ushort port);
        [DllImport(Library)]
        internal static extern void zoned_client_quit(IntPtr client);
        [DllImport(Library)]
        internal static extern int zoned_client_poll(IntPtr client, double now);
        [DllImport(Library)]
        internal static extern IntPtr zoned_client_trouble(IntPtr client);
        [DllImport(Library)]
        internal static extern int zoned_client_set_input(IntPtr client, ref Input input);
        [DllImport(Library)]
        internal static extern int zoned_client_command(IntPtr client, uint kind, byte[] payload, UIntPtr size);
        [DllImport(Library)]
        internal static extern int zoned_client_next_event(IntPtr client, ref EventInfo info, byte[] payload, UIntPtr capacity);
        [DllImport(Library)]
        internal static extern UIntPtr zoned_client_entities(IntPtr client, [In, Out] Entity[] entities, UIntPtr capacity);
        [DllImport(Library)]
        internal static extern int zoned_client_own(IntPtr client, ref Avatar avatar);
        [DllImport(Library)]
        internal static extern int zoned_client_get_world(IntPtr client, ref World world);
        [DllImport(Library)]
        internal static extern int zoned_client_type(IntPtr client, uint index, ref TypeInfo type);
        [DllImport(Library)]
        internal static extern int zoned_client_fields(IntPtr client, uint type);
        [DllImport(Library)]
        internal static extern int zoned_client_field(IntPtr client, uint type, uint index, ref FieldInfo info);
        [DllImport(Library)]
        internal static extern int zoned_client_field_at(IntPtr client, uint entity, uint index, ref FieldValue value);
        [DllImport(Library)]
        internal static extern int zoned_client_field_named(IntPtr client, uint entity, byte[] name, ref FieldValue value);

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
                      string pin = "", string caFile = "", ViewKind view = ViewKind.Extrapolate)
        {
            GCHandle[] pins = Array.ConvertAll(
                new[] { Native.Bytes(name), Native.Bytes(team), ticket ?? new byte[1], Native.Bytes(""), Native.Bytes(pin), Native.Bytes(caFile) },
                bytes => GCHandle.Alloc(bytes, GCHandleType.Pinned));
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
