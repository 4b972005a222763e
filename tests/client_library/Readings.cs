// Calls every reading of the C# binding against a server: Readings.exe PORT WEBSOCKET_PORT SIZES...
// SIZES: structs of the header as NAME=BYTES, by the names of the binding.
using System;
using System.Diagnostics;
using System.Net.WebSockets;
using System.Reflection;
using System.Runtime.InteropServices;
using System.Threading;
using System.Threading.Tasks;
using Zoned;

public static class Readings
{
    private static readonly Stopwatch Clock = Stopwatch.StartNew();

    private static void Expect(bool holds, string what)
    {
        if (!holds) { throw new Exception("not so: " + what); }
    }

    private static void Refuses(Action call, string what)
    {
        try { call(); }
        catch (ZonedException) { return; }
        throw new Exception("not refused: " + what);
    }

    private static void Play(Client client, Func<bool> until, Action eachFrame, string what)
    {
        for (double end = Clock.Elapsed.TotalSeconds + 20; Clock.Elapsed.TotalSeconds < end; Thread.Sleep(16))
        {
            Expect(client.Poll(Clock.Elapsed.TotalSeconds) != ClientState.Closed, client.Trouble);
            eachFrame();
            if (until()) { return; }
        }
        throw new Exception("never: " + what);
    }

    private static void CheckSizes(string[] sizes)
    {
        foreach (string size in sizes)
        {
            string[] parts = size.Split('=');
            Type type = typeof(Client).Assembly.GetType("Zoned." + parts[0]) ?? typeof(Client).Assembly.GetType("Zoned.Native+" + parts[0]);
            Expect(type != null, "the binding has " + parts[0]);
            Expect(Marshal.SizeOf(type) == int.Parse(parts[1]), size + " bytes, not " + Marshal.SizeOf(type));
        }
    }

    private static void ReadWorld(Client client)
    {
        ZoneInfo zone = client.Zone(0);
        Expect(zone.LowerX == -50 && zone.LowerZ == -50 && zone.UpperX == 50 && zone.UpperZ == 50, "region");
        Refuses(() => client.Zone(99), "zone 99");
        Box[] boxes = client.Boxes(0);
        Expect(boxes.Length == zone.Boxes && boxes.Length > 0, "boxes");
        Box block = Array.Find(boxes, box => box.Centre.X == 15 && box.Centre.Y == 1 && box.Centre.Z == 0);
        Expect(block.HalfExtents.X == 2 && block.HalfExtents.Y == 1 && block.HalfExtents.Z == 2 && block.Shut == 1, "block");
        double[] corners = client.Triangles(0);
        Expect(corners.Length == 9 * zone.Triangles && corners.Length > 0, "triangles");
        Expect(Array.Exists(corners, number => number != 0), "corners");
        double day = client.SharedValue("time_of_day");
        Expect(day >= 0 && day < 1e9, "shared value");
        Refuses(() => client.SharedValue("no_such"), "a value that is none");
        Particle[] particles = client.Particles();
        Expect(particles.Length > 0, "particles");
        foreach (Particle particle in particles) { Expect(particle.Age >= 0 && particle.Age <= 1, "age"); }
    }

    private static void ReadEntities(Client client)
    {
        int count = 0;
        Entity wanderer = new Entity();
        Play(client, () => client.Entities(out count).Length > 0 && count >= 12, () => { }, "twelve entities");
        Entity[] all = client.Entities(out count);
        for (int i = 0; i < count; ++i)
        {
            if (client.Type(all[i].Type).Name == "wanderer") { wanderer = all[i]; }
        }
        Entity same;
        Expect(client.Entity(wanderer.Id, out same) && same.Position.X == wanderer.Position.X, "entity by id");
        Expect(!client.Entity(999999, out same), "an entity that is none");
        Avatar own;
        Expect(client.Own(out own), "own");
        Vector along = new Vector { X = same.Position.X, Y = same.Position.Y, Z = same.Position.Z };
        client.Entity(wanderer.Id, out same);
        along.X = same.Position.X - own.Eye.X;
        along.Y = same.Position.Y - own.Eye.Y;
        along.Z = same.Position.Z - own.Eye.Z;
        Aim aim = client.Aim(own.Eye, along, 200);
        Expect(aim.Sights >= 1 && aim.Hit != 0 && aim.Distance > 0 && aim.Tick > 0, "aim");
        Expect(Array.Exists(new[] { aim[0], aim[1] }, sight => sight.Entity == aim.Hit && sight.Publication > 0), "sights");
        Refuses(() => client.Aim(own.Eye, new Vector(), 1), "no direction");
    }

    private static void ReadSession(Client client)
    {
        Expect(Client.AbiVersion == (1 << 16 | 5), "ABI");
        Expect(client.State == ClientState.Online, "state");
        Expect(Math.Abs(client.ServerTime - client.World().ServerTime) < 0.1 && client.ServerTime > 0, "time");
        Stats stats = client.Stats();
        Expect(stats.PacketsIn > 0 && stats.BytesIn > stats.PacketsIn && stats.RttMs > 0 && stats.Malformed == 0, "stats");
        Play(client, () => client.Stats().Corrections > 0, () => { }, "comparisons");
    }

    private static void Join(ushort port)
    {
        using (Client client = new Client("reader"))
        {
            Expect(client.State == ClientState.Idle, "idle");
            Refuses(() => client.StreamOpened(), "a stream without a session of its own");
            client.Connect("127.0.0.1", port);
            Avatar own;
            Play(client, () => client.Own(out own) && client.Stats().RttMs > 0, () => { }, "joined");
            ReadSession(client);
            ReadEntities(client);
            ReadWorld(client);
        }
    }

    /// A session over a WebSocket that lives here; it is cut once, and comes back.
    private static void Stream(ushort port)
    {
        using (Client client = new Client("streamer"))
        {
            ClientWebSocket socket = null;
            byte[] room = new byte[65536];
            int filled = 0;
            Task<WebSocketReceiveResult> coming = null;
            Action hear = () => coming = socket.ReceiveAsync(new ArraySegment<byte>(room, filled, room.Length - filled), CancellationToken.None);
            Action carry = () =>
            {
                for (byte[] frame = client.NextFrame(); frame != null; frame = client.NextFrame())
                {
                    if (socket != null) { socket.SendAsync(new ArraySegment<byte>(frame), WebSocketMessageType.Binary, true, CancellationToken.None).Wait(); }
                }
                StreamWish wish = client.StreamWish();
                if (wish == StreamWish.Open)
                {
                    socket = new ClientWebSocket();
                    socket.Options.AddSubProtocol("zoned");
                    socket.ConnectAsync(new Uri("ws://127.0.0.1:" + port + "/"), CancellationToken.None).Wait();
                    client.StreamOpened();
                    filled = 0;
                    hear();
                }
                while (socket != null && coming.IsCompleted)
                {
                    filled += coming.Result.Count;
                    if (coming.Result.EndOfMessage)
                    {
                        client.StreamFrame(room, filled);
                        filled = 0;
                    }
                    hear();
                }
            };
            client.Begin();
            Avatar own;
            Play(client, () => client.Own(out own) && client.Stats().RttMs > 0, carry, "joined over a WebSocket");
            Expect(client.Stats().Tunnelled == 1, "states inside the stream");
            socket.Abort();
            socket = null;
            client.StreamClosed("cut");
            Play(client, () => client.Stats().Resumed == 1, carry, "came back");
        }
    }

    private delegate IntPtr Allocate(IntPtr context, UIntPtr size);
    private delegate void Release(IntPtr context, IntPtr block);

    private static void OwnMemory()
    {
        int taken = 0, given = 0;
        Allocate allocate = (context, size) => { ++taken; return Marshal.AllocHGlobal((int)size); };
        Release release = (context, block) => { ++given; Marshal.FreeHGlobal(block); };
        Allocator own = new Allocator
        {
            Allocate = Marshal.GetFunctionPointerForDelegate(allocate),
            Release = Marshal.GetFunctionPointerForDelegate(release),
        };
        using (Client client = new Client("thrifty", allocator: own, threads: false))
        {
            Expect(client.State == ClientState.Idle && taken > 0, "memory of its own");
        }
        Expect(given == taken, "all given back");
        Refuses(() => new Client("half", sockets: new Sockets { Open = own.Allocate }), "sockets without functions");
        GC.KeepAlive(allocate);
        GC.KeepAlive(release);
    }

    public static int Main(string[] arguments)
    {
        string[] sizes = new string[arguments.Length - 2];
        Array.Copy(arguments, 2, sizes, 0, sizes.Length);
        CheckSizes(sizes);
        OwnMemory();
        Join(ushort.Parse(arguments[0]));
        Stream(ushort.Parse(arguments[1]));
        Console.WriteLine("all readings");
        return 0;
    }
}
