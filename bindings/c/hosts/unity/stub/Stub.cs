// Subset of Unity that Wall.cs needs, and a program that runs it, for CI without Unity.
using System;
using System.Threading;

namespace UnityEngine
{
    public struct Vector3
    {
        public float x, y, z;
    }

    public class Transform
    {
        public Vector3 position;
        public Vector3 right = new Vector3 { x = 1.0f };
    }

    public class MonoBehaviour
    {
        public readonly Transform transform = new Transform();
        public bool isActiveAndEnabled = true;
        public object component;

        public T GetComponent<T>() where T : class
        {
            return component as T;
        }
    }

    public static class Debug
    {
        public static string Said = "";
        public static void LogWarning(object message) { Said += message + "\n"; }
        public static void LogError(object message) { Said += message + "\n"; }
    }
}

/// A device that the spring of a hand pushes against the wall.
sealed class HandOnAxis : IHapticAxis
{
    double depth = -0.002, velocity;
    double force;
    public double Direction = 1.0;
    public long FailsAt = long.MaxValue;
    public double Last { get { return Volatile.Read(ref force); } }
    public double Position { get { return Direction * Volatile.Read(ref depth); } }
    public bool Pushed;
    public double Deepest, Largest;
    public long Reads;

    public double ReadPosition()
    {
        if (Interlocked.Increment(ref Reads) >= FailsAt)
        {
            throw new InvalidOperationException("the cable is out");
        }
        return Direction * depth;
    }

    public void WriteForce(double newForce)
    {
        Volatile.Write(ref force, newForce);
        newForce *= Direction;
        Pushed = Pushed || newForce < 0.0;
        Largest = Math.Max(Largest, Math.Abs(newForce));
        // 0.25 kg, pushed with 2 N and damped by a hand of 2 N s/m, over 1 ms.
        velocity += (2.0 - 2.0 * velocity + newForce) / 0.25 * 0.001;
        Volatile.Write(ref depth, depth + velocity * 0.001);
        Deepest = Math.Max(Deepest, depth);
    }
}

static class Program
{
    static int failures;

    static void Expect(bool holds, string what)
    {
        if (!holds)
        {
            Console.Error.WriteLine("not so: " + what);
            failures++;
        }
    }

    /// Returns the message with which a contact of these parameters is rejected.
    static void Refused(Palpate.ContactParams contact, Palpate.LoopParams loop, string words, string method,
        params Palpate.Setting[] settings)
    {
        try
        {
            using (new Palpate.Contact(contact, loop, method, settings))
            {
                Expect(false, "it is refused: " + words);
            }
        }
        catch (Palpate.ParameterException error)
        {
            Expect(error.Message.StartsWith(words, StringComparison.Ordinal), error.Message);
        }
    }

    /// Waits until the device has been read `count` more times.
    static void Ticks(HandOnAxis device, long count)
    {
        long until = Interlocked.Read(ref device.Reads) + count;
        while (Interlocked.Read(ref device.Reads) < until)
        {
            Thread.Sleep(1);
        }
    }

    static void Walls()
    {
        // Unity enables the component before a device can be set: the wall warns and renders nothing.
        var wall = new Wall();
        wall.OnEnable();
        wall.Update();
        Expect(!wall.Running && UnityEngine.Debug.Said.Contains("set Wall.Device"), "a wall without a device says so");
        wall.OnDisable();

        // Setting the device of an enabled wall starts the loop.
        var device = new HandOnAxis();
        wall.Device = device;
        Ticks(device, 1500);
        wall.Update();
        Expect(wall.Running, "a device that is set starts the loop");
        Expect(device.Pushed && device.Deepest > 0.0005, "the device has met the wall, and was pushed back");
        Expect(device.Largest <= 20.0, "no force exceeds the limit");

        // A stiffness change at run time: 2 N penetrate half as deep.
        double before = wall.Penetration;
        wall.Stiffness = 4000.0;
        wall.Update();
        Ticks(device, 1500);
        Expect(wall.Penetration < 0.5 * before, "the new stiffness acts: " + before + " m, then " + wall.Penetration + " m");
        UnityEngine.Debug.Said = "";
        wall.Stiffness = -1.0;
        wall.Update();
        Ticks(device, 10);
        Expect(wall.Running && UnityEngine.Debug.Said.Contains("stiffness is -1 N/m"), "a wrong stiffness is refused by name");
        // A period change restarts the loop; valid parameters are rendered again after invalid ones.
        UnityEngine.Debug.Said = "";
        wall.Stiffness = 4000.0;
        wall.Period = 0.0;
        wall.Update();
        Ticks(device, 10);
        Expect(wall.Running && UnityEngine.Debug.Said.Contains("period is 0 s"), "a wrong period is refused by name");
        wall.Period = 0.002;
        wall.Update();
        Ticks(device, 10);
        wall.Period = 0.001;
        wall.Update();
        Ticks(device, 10);
        Expect(wall.Running && UnityEngine.Debug.Said.Split('\n').Length == 2, "a right period is rendered: "
            + UnityEngine.Debug.Said);

        // The surface moves with the object, and the device, pushed against it, follows.
        double at = device.Position;
        wall.transform.position.x = -0.01f;
        wall.Update();
        Ticks(device, 3000);
        Expect(Math.Abs(device.Position - at - -0.01) < 0.002, "the wall has moved by -10 mm, and the device from " + at
            + " m to " + device.Position + " m");
        wall.OnDisable();
        Expect(device.Last == 0.0 && !wall.Running, "the force is taken off at the end");

        // Rotated by 180 degrees the wall is solid towards -x; the device is found as a component of the object.
        var other = new HandOnAxis { Direction = -1.0 };
        var turned = new Wall { component = other };
        turned.transform.right.x = -1.0f;
        turned.OnEnable();
        Ticks(other, 1500);
        Expect(other.Pushed && other.Position < -0.0005, "a wall that is turned round pushes towards +x");
        turned.OnDisable();

        // A driver that throws stops the loop with zero force, and Unity shows the error.
        UnityEngine.Debug.Said = "";
        var failing = new HandOnAxis { FailsAt = 20 };
        var last = new Wall { component = failing };
        last.OnEnable();
        while (Interlocked.Read(ref failing.Reads) < 20 || failing.Last != 0.0)
        {
            Thread.Sleep(1);
        }
        while (!UnityEngine.Debug.Said.Contains("the cable is out"))
        {
            last.Update();
            Thread.Sleep(1);
        }
        Expect(!last.Running, "a driver that throws stops the loop");
        Console.WriteLine("Unity: the device rests {0:F6} m in the wall", wall.Penetration);
    }

    static int Main()
    {
        var loop = Palpate.LoopParams.Default(0.001);
        Expect(loop.ForceLimit == 20.0, "the force limit is 20 N");
        var contact = Palpate.ContactParams.Default(1000.0);
        using (var basic = new Palpate.Contact(contact, loop, "basic"))
        {
            Expect(basic.Step(0.001) == -1.0, "1 mm in 1000 N/m are 1 N");
            Palpate.Output output;
            basic.Step(Palpate.Sample.At(double.NaN), out output);
            Expect(output.Fault == Palpate.Fault.PositionNotFinite, "a position that is no number is refused");
            Expect(output.Phase == Palpate.Phase.Waiting, "and the object waits");
            contact.Stiffness = 2000.0;
            basic.Change(contact, loop, "basic");
        }
        contact.Stiffness = 1000.0;
        // 1 N from the spring plus 0.5 N s/m times 1 m/s from the damper.
        var damping = new Palpate.Setting("damping_n_s_per_m", 0.5);
        using (var damped = new Palpate.Contact(contact, loop, "virtual-damper", damping))
        {
            damped.Step(0.0);
            Expect(Math.Abs(damped.Step(0.001) - -1.5) < 1e-12, "the damping that was set acts");
            damped.Change(contact, loop, "virtual-damper", damping, new Palpate.Setting("prediction", "last-step"));
        }
        Refused(contact, loop, "virtual-damper has no setting \"dampening\"; it has ",
            "virtual-damper", new Palpate.Setting("dampening", 0.5));
        Refused(contact, loop, "damping is -1 N s/m, but must be ",
            "virtual-damper", new Palpate.Setting("damping_n_s_per_m", -1.0));
        Refused(contact, loop, "prediction is \"a guess\", but must be \"last-step\", \"first-order-adaptive-window\", \"extrapolation\" or \"observer\"",
            "virtual-damper", damping, new Palpate.Setting("prediction", "a guess"));
        contact.Stiffness = -1.0;
        Refused(contact, loop, "stiffness is -1 N/m, but must be finite and greater than 0", "basic");

        Walls();
        return failures == 0 ? 0 : 1;
    }
}
