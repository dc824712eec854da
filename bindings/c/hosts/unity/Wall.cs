// A wall for a haptic device. The loop runs in its own thread, because Unity's Update runs at the display rate,
// which is too low for haptics.
//
// License: MIT OR Apache-2.0
using System;
using System.Diagnostics;
using System.Threading;
using UnityEngine;

/// <summary>One axis of a device. The wall finds a MonoBehaviour that implements it on its own object.</summary>
public interface IHapticAxis
{
    /// <summary>Returns the position of the end-point along the x axis of the scene [m]. Called by the loop
    /// thread.</summary>
    double ReadPosition();

    /// <summary>Sets the force on the device along the x axis of the scene [N]. Called by the loop thread.</summary>
    void WriteForce(double force);
}

/// <summary>A wall whose surface passes through the position of its object, normal to the x axis of the scene (1
/// unit is 1 m). It is solid on the side to which the object's local x axis (transform.right) points. The loop
/// interpolates the positions of the last two frames of a moving wall.</summary>
public sealed class Wall : MonoBehaviour
{
    public double Stiffness = 1000.0; // [N/m]
    public double DeviceMass = 0.25; // [kg]
    public double Period = 0.001; // [s]

    IHapticAxis device;
    double penetration;
    volatile bool running;
    Thread thread;
    volatile Exception failure;

    // Parameters last read from the component, parameters at the start of the loop, and the next parameters, which
    // the loop takes between two ticks.
    Parameters given, begun, next;

    // Path of the surface over one frame, for the loop.
    SurfacePath path;

    /// <summary>The device. Without one, OnEnable uses the component of the same object that implements IHapticAxis. A
    /// running loop restarts with the new device.</summary>
    public IHapticAxis Device
    {
        get { return device; }
        set
        {
            bool wasRunning = running;
            Stop();
            device = value;
            if (wasRunning || (isActiveAndEnabled && value != null))
            {
                OnEnable();
            }
        }
    }

    /// <summary>Penetration of the device into the wall at the last tick [m]; negative outside.</summary>
    public double Penetration { get { return Volatile.Read(ref penetration); } }

    /// <summary>Whether the loop runs.</summary>
    public bool Running { get { return running; } }

    enum Side { Positive, Negative }

    /// Parameters of the loop.
    sealed class Parameters
    {
        internal double Stiffness, DeviceMass, Period;
        internal Side Side;

        internal Palpate.ContactParams Contact { get { return Palpate.ContactParams.Default(Stiffness); } }

        internal Palpate.LoopParams Loop
        {
            get
            {
                var loop = Palpate.LoopParams.Default(Period);
                loop.DeviceMass = DeviceMass;
                return loop;
            }
        }

        internal bool Equals(Parameters other)
        {
            return Stiffness == other.Stiffness && DeviceMass == other.DeviceMass && NeedsNoRestart(other);
        }

        internal bool NeedsNoRestart(Parameters other)
        {
            return Period == other.Period && Side == other.Side;
        }
    }

    /// Surface positions at the beginning and the end of a frame [m], and both clock times [s].
    sealed class SurfacePath
    {
        internal double From, To, Begin, End;

        internal double At(double time)
        {
            if (time >= End)
            {
                return To;
            }
            return From + (To - From) * Math.Max(0.0, time - Begin) / (End - Begin);
        }
    }

    static readonly Stopwatch Clock = Stopwatch.StartNew();

    static double Now { get { return Clock.Elapsed.TotalSeconds; } }

    public void OnEnable()
    {
        if (running)
        {
            return;
        }
        device = device ?? GetComponent<IHapticAxis>();
        if (device == null)
        {
            UnityEngine.Debug.LogWarning(
                "Wall: no device, so nothing is rendered: set Wall.Device, or add a component that implements IHapticAxis");
            return;
        }
        Palpate.Contact contact;
        given = Read();
        try
        {
            contact = Make(given);
        }
        catch (Exception error)
        {
            UnityEngine.Debug.LogError("Wall: nothing is rendered: " + error.Message);
            return;
        }
        double surface = transform.position.x;
        double now = Now;
        Volatile.Write(ref path, new SurfacePath { From = surface, To = surface, Begin = now, End = now });
        Interlocked.Exchange(ref next, null);
        failure = null;
        running = true;
        IHapticAxis used = device;
        Parameters first = begun = given;
        thread = new Thread(() => Run(contact, used, first)) { Priority = System.Threading.ThreadPriority.Highest };
        thread.Start();
    }

    public void OnDisable()
    {
        Stop();
    }

    /// <summary>Passes the position of the wall and changed parameters to the loop, once per frame.</summary>
    public void Update()
    {
        if (failure != null)
        {
            Exception error = failure;
            Stop();
            UnityEngine.Debug.LogError("Wall: the loop has stopped: " + error.Message);
            return;
        }
        if (!running)
        {
            return;
        }
        SurfacePath before = Volatile.Read(ref path);
        double now = Now;
        double frame = Math.Max(1e-3, Math.Min(0.1, now - before.Begin));
        double surface = transform.position.x;
        if (surface != before.To || now < before.End)
        {
            Volatile.Write(ref path,
                new SurfacePath { From = before.At(now), To = surface, Begin = now, End = now + frame });
        }
        Parameters changed = Read();
        if (changed.Equals(given))
        {
            return;
        }
        given = changed;
        try
        {
            // Check here, where Unity shows an error; the loop then keeps its parameters.
            Make(changed).Dispose();
        }
        catch (Exception error)
        {
            UnityEngine.Debug.LogError("Wall: the parameters are unchanged: " + error.Message);
            return;
        }
        if (changed.NeedsNoRestart(begun))
        {
            Interlocked.Exchange(ref next, changed);
        }
        else
        {
            Stop();
            OnEnable();
        }
    }

    void Stop()
    {
        running = false;
        if (thread != null)
        {
            thread.Join();
            thread = null;
        }
        failure = null;
    }

    Parameters Read()
    {
        return new Parameters
        {
            Stiffness = Stiffness,
            DeviceMass = DeviceMass,
            Period = Period,
            Side = transform.right.x >= 0.0f ? Side.Positive : Side.Negative,
        };
    }

    static Palpate.Contact Make(Parameters parameters)
    {
        return new Palpate.Contact(parameters.Contact, parameters.Loop);
    }

    /// The loop, in coordinates of the wall: 0 is the surface, positive is inside.
    void Run(Palpate.Contact contact, IHapticAxis axis, Parameters first)
    {
        double step = first.Period;
        double inward = first.Side == Side.Positive ? 1.0 : -1.0;
        try
        {
            using (contact)
            {
                double start = Now;
                double last = 0.0;
                for (long tick = 0; running; tick++)
                {
                    while (Now - start < tick * step)
                    {
                        Thread.SpinWait(20);
                    }
                    Parameters changed = Interlocked.Exchange(ref next, null);
                    if (changed != null)
                    {
                        contact.Change(changed.Contact, changed.Loop);
                    }
                    double now = Now;
                    double position = axis.ReadPosition();
                    var sample = Palpate.Sample.At(inward * (position - Volatile.Read(ref path).At(now)));
                    if (tick > 0)
                    {
                        sample.Elapsed = now - last;
                        sample.HasElapsed = 1;
                    }
                    last = now;
                    Palpate.Output output;
                    axis.WriteForce(inward * contact.Step(sample, out output));
                    Volatile.Write(ref penetration, output.Penetration);
                }
            }
        }
        catch (Exception error)
        {
            failure = error;
        }
        finally
        {
            try
            {
                axis.WriteForce(0.0);
            }
            catch (Exception error)
            {
                failure = failure ?? error;
            }
        }
    }
}
